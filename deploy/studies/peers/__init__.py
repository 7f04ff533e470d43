"""The same scenarios under other laws."""
