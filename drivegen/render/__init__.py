"""Pictures of maps, scenes and goals, drawn with OpenCV."""
