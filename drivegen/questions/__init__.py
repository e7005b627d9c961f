"""What a vision-language model is asked about goals, whom it is asked about, and what its ranking is worth."""
