"""Monitoring a run: live page, terminal table, Foxglove and metrics.

A source (`watcher`) keeps a view (`live`) up to date; `web`, `terminal`, `foxglove` and `metrics` show it.
"""
