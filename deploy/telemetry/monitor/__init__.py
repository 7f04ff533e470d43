"""Seeing a run while it goes on, from outside or from within: a live page and a terminal table.

A `source` (`watcher`) keeps a `view` up to date; `web` and `terminal` show it.
"""
