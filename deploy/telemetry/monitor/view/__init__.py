"""A running fleet as a watcher sees it: messages in, plain data for a page or table out."""
