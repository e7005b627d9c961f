"""How often a driver fails in traffic that follows a law that is written down, and how few runs tell."""
