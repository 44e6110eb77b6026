"""A study on a SLURM cluster, as docs/python.md shows it: Debian's SLURM on this machine."""

import os
import sys

import pytest

import palpate
import slurm

SCENE = {"duration": 0.05, "bodies": [{"name": "ball", "ball": {"radius": 0.05, "resolution": 2}, "material": {}}]}


@pytest.mark.long
@pytest.mark.skipif(not slurm.is_here(), reason="needs root and Debian's slurmctld, slurmd and slurm-client")
def test_a_study_runs_on_slurm_with_the_bits_of_this_machine(tmp_path):
    from dask.distributed import Client
    from dask_jobqueue import SLURMCluster

    parameters = {"time_step": [0.01, 0.0125, 0.025, 0.05]}
    (tmp_path / "slurm").mkdir()
    with slurm.Slurm(tmp_path / "slurm", processors=2):
        with SLURMCluster(cores=1, memory="900MB", processes=1, walltime="00:10:00", python=sys.executable, interface="lo",
                          local_directory=str(tmp_path), log_directory=str(tmp_path), worker_extra_args=["--no-dashboard"],
                          scheduler_options={"dashboard_address": None},
                          job_script_prologue=[f"export PYTHONPATH={os.environ['PYTHONPATH']}"]) as cluster:
            cluster.scale(jobs=2)
            with Client(cluster) as client:
                client.wait_for_workers(2, timeout=120)
                far = palpate.sweep(SCENE, parameters, client=client, measure=lambda simulation: {"job": os.environ["SLURM_JOB_ID"]})
    near = palpate.sweep(SCENE, parameters, workers=1)
    assert far["status"].tolist() == ["done"] * 4, far["error"].tolist()
    assert far["state_hash"].tolist() == near["state_hash"].tolist()
    assert set(far["job"]) <= {"1", "2"} and len(set(near["state_hash"])) == 4
