"""What several adversaries are built from: the arena, what is allowed, goals, and how near a planned track comes."""
