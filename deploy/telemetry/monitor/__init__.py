"""Seeing a run while it goes on, from outside or from within: a live page and a terminal table.

A `source` (`watcher`, `attachment`, `player`) keeps a `view` up to date; `server` and `terminal` show it.
"""
