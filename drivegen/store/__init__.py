"""The record: scenarios, samples, goals and metric rows as Parquet and JSON, and DuckDB views over them."""
