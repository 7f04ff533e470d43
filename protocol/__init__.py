"""What crosses the network and what describes a run: messages, codec, keys, scenario, buses, errors."""
