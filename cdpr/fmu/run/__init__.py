"""FMUs with their native code: `running` starts one, in this process (`slave`) or another (`process`, `worker`)."""
