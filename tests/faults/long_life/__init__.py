"""A campaign of many epochs through the real store: what it costs must not creep."""
