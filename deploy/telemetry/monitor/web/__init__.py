"""The live page: its server, its websocket, and the page itself."""
