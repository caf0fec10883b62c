"""Runs the job that the program `potamoi` writes to standard input."""

import json
import logging
import os
import sys
import threading


def end_with_the_program():
    """Ends this process when the program that started it has ended, however."""
    while sys.stdin.buffer.read(1 << 16):
        pass
    os._exit(1)


def main():
    line = sys.stdin.buffer.readline()
    try:
        job = json.loads(line)
    except ValueError:
        sys.exit("potamoi.sweep is started by the program: potamoi sweep PLAN --work-dir DIR --engine dask "
                 "--scheduler ADDRESS")
    threading.Thread(target=end_with_the_program, daemon=True).start()
    # What happens to workers is told in the program's own words.
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    from ._runner import Failed, run

    try:
        run(job)
    except Failed as error:
        print(json.dumps({"error": str(error), "is_input": error.is_input}), flush=True)
    sys.stdout.flush()
    # Threads of the client are of no use any more.
    os._exit(0)


if __name__ == "__main__":
    main()
