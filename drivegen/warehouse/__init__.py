"""All results in one DuckDB file with views, and what finished runs of the pipeline left behind."""
