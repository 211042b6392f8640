"""One module per subcommand of hpc-gfmd: add_parser(subparsers) and main(args) -> exit code."""
