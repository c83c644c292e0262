unset TRIBOSWEEP_STORE
# Exit code 2 says that shards are missing; which ones, and how to run them, stands above it.
exec "$program" store merge "$exports" --into "$merged"
