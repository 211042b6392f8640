"""One module per subcommand of hpc-gfmd: add_parser(subparsers) -> its parser, and main(args) ->
exit code."""
