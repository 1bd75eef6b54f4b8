"""The service: command line, HTTP interface, jobs and store around the same pipeline."""
