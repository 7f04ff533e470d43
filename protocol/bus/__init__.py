"""The bus: publish, subscribe, request and presence, on zenoh and within one process; connections."""
