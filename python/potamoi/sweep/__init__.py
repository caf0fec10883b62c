"""Sweeps of Potamoi over the workers of Dask distributed.

``potamoi sweep PLAN --work-dir DIR --engine dask --scheduler ADDRESS`` starts ``python3 -m potamoi.sweep``,
which talks to that program alone: it reads one line of JSON, the job, and prints a line for each finished point.

=============  ==========================================================================================
module         contents
=============  ==========================================================================================
``_address``   which addresses are talked to: TLS, or the loopback
``_worker``    what runs on workers; sent by value, so that workers need no package but Dask itself
``_queue``     which points are handed out next, so that no two workers count the same
``_runner``    the job from its first worker to its last line
=============  ==========================================================================================
"""
