"""Files by which an existing engine runs a secured fleet: Docker Compose, Kubernetes, systemd."""
