"""Words for roads and traffic, read by one phrase table and spoken from it."""
