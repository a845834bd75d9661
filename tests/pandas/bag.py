"""Reads the bag of `perirobot export` by other code, from the definitions that it holds, and finds in it what the arrays and clouds
of the same folder say; then writes bags as other recorders do: with each compression, of two sensors, in frames of frames.

The folder is named on the command line; tests/backends/recorded.rs scores what is written.
"""

import sys
from pathlib import Path

import numpy as np
from mcap.reader import make_reader
from mcap.writer import CompressionType
from mcap_ros2.decoder import DecoderFactory
from mcap_ros2.writer import Writer

folder = Path(sys.argv[1])
view = np.load(folder / "view.npz")
with open(folder / "view.mcap", "rb") as file:
    reader = make_reader(file, decoder_factories=[DecoderFactory()])
    assert reader.get_header().profile == "ros2"
    schemas = {schema.name: schema.data.decode() for schema in reader.get_summary().schemas.values()}
    said = {channel.topic: message for _, channel, _, message in reader.iter_decoded_messages()}
assert set(said) == {"/tf_static", "/lidar/points", "/octomap_binary", "/voxels"}, set(said)

frame, = said["/tf_static"].transforms
assert (frame.header.frame_id, frame.child_frame_id) == ("world", "lidar")
q, at = frame.transform.rotation, frame.transform.translation
turned = np.array([
    [1 - 2 * (q.y**2 + q.z**2), 2 * (q.x * q.y - q.z * q.w), 2 * (q.x * q.z + q.y * q.w)],
    [2 * (q.x * q.y + q.z * q.w), 1 - 2 * (q.x**2 + q.z**2), 2 * (q.y * q.z - q.x * q.w)],
    [2 * (q.x * q.z - q.y * q.w), 2 * (q.y * q.z + q.x * q.w), 1 - 2 * (q.x**2 + q.y**2)],
])
cloud = said["/lidar/points"]
assert cloud.header.frame_id == "lidar" and [field.name for field in cloud.fields] == ["x", "y", "z", "ray"]
point = np.dtype([("at", "<f4", 3), ("ray", "<u4")])
points = np.frombuffer(bytes(cloud.data), point)
body = (folder / "points-lidar.ply").read_bytes().split(b"end_header\n", 1)[1]
ply = np.frombuffer(body, np.dtype([("at", "<f4", 3), ("ray", "<u4"), ("verdict", "u1")]))
assert len(points) == len(ply) > 0 and (points["ray"] == ply["ray"]).all()
world = points["at"].astype(float) @ turned.T + [at.x, at.y, at.z]
assert np.abs(world - ply["at"]).max() < 1e-5

voxels = said["/voxels"]
shape = view["verdict"].shape
assert (voxels.column_count, voxels.row_count, len(voxels.data) // voxels.slice_stride) == shape
assert voxels.cell_size.x == voxels.cell_size.z == view["voxel_size_m"]
assert [voxels.pose.position.x, voxels.pose.position.y, voxels.pose.position.z] == list(view["origin_m"])
# Slices along z, rows along y, x the fastest.
values = np.frombuffer(bytes(voxels.data), np.uint8).reshape(shape[2], shape[1], shape[0], voxels.cell_stride)
assert [field.name for field in voxels.fields] == ["verdict", "red", "green", "blue", "alpha"]
assert (values[..., 0].transpose(2, 1, 0) == view["verdict"]).all()
opaque = np.isin(view["verdict"], [0, 2, 4])
assert ((values[..., 4].transpose(2, 1, 0) == 255) == opaque).all() and opaque.any()

octree = said["/octomap_binary"]
assert octree.binary and octree.id == "OcTree" and octree.resolution == view["voxel_size_m"]
file = (folder / "labels.bt").read_bytes()
assert (np.array(octree.data, np.int8).tobytes()) == file.split(b"\ndata\n", 1)[1]

# The same cloud of two sensors, of which the second is 0.4 m higher, below a frame that hangs in the world.
up = {"x": 0.0, "y": 0.0, "z": 0.4}
none = {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}
stamp = {"sec": 5, "nanosec": 0}
place = {"x": at.x, "y": at.y, "z": at.z}
rotation = {"x": q.x, "y": q.y, "z": q.z, "w": q.w}
tree = [("mast", "/top", up, none), ("world", "mast", place, rotation)]
transforms = [
    {"header": {"stamp": stamp, "frame_id": holder}, "child_frame_id": name,
     "transform": {"translation": translation, "rotation": turn}}
    for holder, name, translation, turn in tree
]
fields = [{"name": name, "offset": 8 * i + 4, "datatype": 8, "count": 1} for i, name in enumerate("xyz")]
for compression in [CompressionType.NONE, CompressionType.LZ4, CompressionType.ZSTD]:
    with open(folder / f"{compression.name.lower()}.mcap", "wb") as file:
        writer = Writer(file, compression=compression)
        frames = writer.register_msgdef("tf2_msgs/msg/TFMessage", schemas["tf2_msgs/msg/TFMessage"])
        clouds = writer.register_msgdef("sensor_msgs/msg/PointCloud2", schemas["sensor_msgs/msg/PointCloud2"])

        def write(name, time):
            records = np.zeros(len(points), np.dtype({"names": ["at"], "formats": [("<f8", 3)], "offsets": [4], "itemsize": 32}))
            records["at"] = points["at"]
            data = {"header": {"stamp": stamp, "frame_id": name}, "height": 1, "width": len(points), "fields": fields,
                    "is_bigendian": False, "point_step": 32, "row_step": 32 * len(points), "data": records.tobytes(),
                    "is_dense": True}
            writer.write_message("/points", clouds, data, log_time=time)

        # Out of order: by time, the lower sensor's is the first.
        write("top", 9)
        write("mast", 4)
        writer.write_message("/tf_static", frames, {"transforms": transforms}, log_time=9)
        writer.finish()
print(f"{len(points)} points and {values.shape} voxels are equal")
