"""Seeing a run while it goes on: a live page and a terminal table, from outside or from within."""

from deploy.monitor.attachment import Attachment, attach, watch_local
from deploy.monitor.player import Player
from deploy.monitor.server import Server, serve_in_thread
from deploy.monitor.source import Source

__all__ = ["Attachment", "Player", "Server", "Source", "attach", "serve_in_thread", "watch_local"]
