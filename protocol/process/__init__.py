"""Parts of every process: title, log, signals, installation."""
