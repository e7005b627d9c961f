"""What several simulators are built from, and what is made of their runs."""
