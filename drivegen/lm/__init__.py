"""Language models behind one seam: a prompt in, a validated answer out, or a typed failure that callers have a fallback for."""
