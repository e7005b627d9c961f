"""The record: scenarios, samples, goals and metric rows as Parquet and JSON, whole or not at all."""
