"""One module per subcommand of `disknav`; each imports what it needs when it is called."""
