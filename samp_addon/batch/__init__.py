"""Takes without a window: the command line, the jobs file, what is done already, and the run itself."""
