"""Traffic as it was asked for in words: a typed request, where its vehicles stand, what they do, and what came of it."""
