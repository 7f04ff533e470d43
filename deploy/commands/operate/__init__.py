"""Commands of those who operate a fleet process by process: start, deploy, issue keys, probe."""
