"""What several planners are built from."""
