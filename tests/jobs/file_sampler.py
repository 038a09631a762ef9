"""A remote sampler of picking models, without SDK and network: `FileService` as a backend."""

from __future__ import annotations

import os
from typing import ClassVar

from jobs.fake_service import FileService

from qrobot.backends import Capabilities
from qrobot.backends.sampler import PickingSampler
from qrobot.errors import CredentialsError
from qrobot.jobs import PARAMETERS, JobOptions, run_job


class FileSampler(FileService, PickingSampler):
    """Registered by the tests as ``file-service``; its folder is in the environment."""

    capabilities = Capabilities(kind="sampler", local=False)
    properties: ClassVar = {}
    parameters: ClassVar = {"num_reads": [], **PARAMETERS}

    def __init__(self):
        FileService.__init__(self, os.environ["FILE_SERVICE"])
        if os.environ.get("FILE_SERVICE_REFUSES"):
            self.errors["submit"] = [CredentialsError("File Service refused the token")]

    def sample(self, bqm, **parameters):
        return run_job(self, bqm, JobOptions.take_from(parameters), **parameters)
