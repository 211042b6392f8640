"""One module per subcommand of hpc-gfmd: main(args) -> exit code; the arguments of all stand in
commands.toml. common.py and limits.py serve them."""
