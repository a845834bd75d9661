"""Where packages are, for xacro's $(find NAME): those that the scene file names, then those of a ROS that is set up.

It stands in for the module of ROS 2 of that name, which `pip install xacro` does not bring."""

import os


class PackageNotFoundError(KeyError):
    """No package of that name is known."""


def get_package_share_directory(name):
    """The folder of a package."""
    for line in os.environ["PERIROBOT_PACKAGES"].splitlines():
        known, _, folder = line.partition("=")
        if known == name:
            return folder
    for prefix in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep):
        share = os.path.join(prefix, "share", name)
        if prefix and os.path.isdir(share):
            return share
    for folder in os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep):
        for found in (folder, os.path.join(folder, name)):
            if folder and os.path.basename(found) == name and os.path.isfile(os.path.join(found, "package.xml")):
                return found
    raise PackageNotFoundError(
        'package "%s" is not known: say where it is, as in packages = { %s = "DIR" } in the scene file' % (name, name)
    )
