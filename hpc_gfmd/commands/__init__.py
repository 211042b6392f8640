"""One file per subcommand of hpc-gfmd, listed in cli.py.

Each has HELP (one line), DESCRIPTION, `add_arguments(parser)` and `main(args)`, which returns the
exit code; slow imports stand inside functions. common.py and limits.py are not commands.
"""
