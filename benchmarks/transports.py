"""The bus and its peers, each as the two ends of a ping-pong between two processes.

Every end sends payloads of the size asked for, whose first eight bytes are a time, and
receives such payloads; what it has received is at hand in the main thread, as bytes or array.
"""

import socket
import struct
import threading
import time
from collections.abc import Callable
from typing import Any, Protocol

import numpy as np
import zenoh
import zmq
from zenoh.handlers import Callback, FifoChannel

from benchmarks.messages import Opaque
from benchmarks.pace import wait_until
from bus import Input, Node
from bus.session import LOOPBACK, open_session
from bus.threads import adopt
from robot_model.messages import SensorFrame

LARGEST = 1 << 20  # bytes
TIME = struct.Struct("<d")  # monotonic [ns]; exact for a hundred days


class End(Protocol):
    """One end of a ping-pong."""

    def send(self, size: int, now: float) -> None:
        """Send a payload of ``size`` bytes that begins with a time [ns]."""
        ...

    def receive(self) -> tuple[int, float]:
        """Wait for the next payload; return its size and the time in it [ns]."""
        ...

    def close(self) -> None:
        """Let go of everything."""
        ...


class Buffers:
    """One payload per size, filled once, so that no transport pays for making them."""

    def __init__(self, make: Callable[[int], Any]):
        self._make = make
        self._made: dict[int, Any] = {}

    def __getitem__(self, size: int) -> Any:
        if size not in self._made:
            self._made[size] = self._make(size)
        return self._made[size]


class BytesEnd:
    """An end that carries plain bytes."""

    def __init__(self) -> None:
        self._buffers = Buffers(bytearray)

    def send(self, size: int, now: float) -> None:
        buffer = self._buffers[size]
        TIME.pack_into(buffer, 0, now)
        self._put(buffer)

    def receive(self) -> tuple[int, float]:
        data = self._get()
        return len(data), TIME.unpack_from(data)[0]

    def _put(self, buffer: bytearray) -> None:
        raise NotImplementedError

    def _get(self) -> Any:
        raise NotImplementedError

    def close(self) -> None:
        raise NotImplementedError


class BusEnd:
    """Ports of ours, with a message type that makes the payload: opaque, or a sensor frame."""

    message_type: type = Opaque

    def __init__(self, endpoint: str, here: str, there: str):
        self.node = Node(f"{self.message_type.__name__}_{here}".lower(), endpoint, signals=False)
        names = [f"/benchmark/{self.message_type.__name__}/{side}:o" for side in (here, there)]
        self._output = self.node.output(names[0], self.message_type, max_message=2 * LARGEST)
        own = names[0].removesuffix("o") + "i"
        self._input: Input = self.node.input(
            own, self.message_type, names[1], depth=8, max_message=2 * LARGEST
        )
        self._messages = Buffers(self.make)
        self.node.ready()
        wait_until(lambda: self._output.matched)

    @staticmethod
    def make(size: int) -> tuple[Any, np.ndarray]:
        """Return a message of a size and the array whose first number is the time."""
        block = np.ones((size // 64, 8))
        return Opaque(block=block), block[0]

    @staticmethod
    def open(data: Any) -> tuple[int, float]:
        """Return the size of a message's payload, and the time in it."""
        return data.block.nbytes, data.block[0, 0]

    def send(self, size: int, now: float) -> None:
        message, array = self._messages[size]
        array[0] = now
        self._output.write(message)

    def receive(self) -> tuple[int, float]:
        while (received := self._input.read()) is None:
            self.node.wait(1.0)
        return self.open(received.data)

    def close(self) -> None:
        self.node.close()


class FrameEnd(BusEnd):
    """The same with the sensor frame of a robot of 32 joints."""

    message_type = SensorFrame

    @staticmethod
    def make(size: int) -> tuple[Any, np.ndarray]:
        n, k, m = 32, 6, 3
        joint = [np.linspace(-1.0, 1.0, n) for _ in range(4)]
        inertial = [np.ones((m, 3)) for _ in range(3)]
        flags = [np.ones(count, bool) for count in (n, k, m)]
        arrays = (*joint, np.ones((k, 6)), *inertial)
        names = ("q", "dq", "ddq", "motor_torque", "ft", "imu_gyro", "imu_acc", "imu_dgyro")
        valid = dict(zip(("joint_valid", "ft_valid", "imu_valid"), flags, strict=True))
        frame = SensorFrame(**dict(zip(names, arrays, strict=True)), **valid)
        return frame, frame.q

    @staticmethod
    def open(data: Any) -> tuple[int, float]:
        return 0, data.q[0]


class ZenohEnd(BytesEnd):
    """Zenoh's own Python interface with the settings of our sessions; the main thread receives."""

    def __init__(self, endpoint: str, here: str, there: str):
        super().__init__()
        self._session = open_session("peer", [endpoint], [LOOPBACK])
        key = f"benchmark/{type(self).__name__}/"
        self._publisher = self._session.declare_publisher(
            key + here,
            congestion_control=zenoh.CongestionControl.DROP,
            priority=zenoh.Priority.REAL_TIME,
            express=True,
        )
        self._subscriber = self._subscribe(key + there)
        wait_until(lambda: self._publisher.matching_status.matching)  # type: ignore[attr-defined]

    def _subscribe(self, key: str) -> zenoh.Subscriber:
        return self._session.declare_subscriber(key, FifoChannel(16))

    def _put(self, buffer: bytearray) -> None:
        self._publisher.put(buffer)

    def _get(self) -> bytes:
        return self._subscriber.recv().payload.to_bytes()

    def close(self) -> None:
        self._session.close()


class ZenohCallbackEnd(ZenohEnd):
    """The same, but Zenoh's thread takes the sample and wakes the main thread by a lock."""

    def _subscribe(self, key: str) -> zenoh.Subscriber:
        self._came = threading.Lock()
        self._came.acquire()
        return self._session.declare_subscriber(key, Callback(self._take, indirect=False))

    def _take(self, sample: zenoh.Sample) -> None:
        adopt()
        self._data = sample.payload.to_bytes()
        self._came.release()

    def _get(self) -> bytes:
        self._came.acquire()
        return self._data


class ZmqEnd(BytesEnd):
    """A pair of pyzmq sockets over TCP; the echo binds."""

    def __init__(self, endpoint: str, here: str, there: str):
        super().__init__()
        self._context = zmq.Context()
        self._socket = self._context.socket(zmq.PAIR)
        address = endpoint.replace("tcp/", "tcp://")
        (self._socket.bind if here == "pong" else self._socket.connect)(address)

    def _put(self, buffer: bytearray) -> None:
        self._socket.send(buffer)

    def _get(self) -> bytes:
        return self._socket.recv()

    def close(self) -> None:
        self._context.destroy(linger=0)


class TcpEnd(BytesEnd):
    """A plain TCP socket; each payload behind its length."""

    def __init__(self, endpoint: str, here: str, there: str):
        super().__init__()
        host, _, port = endpoint.removeprefix("tcp/").partition(":")
        if here == "pong":
            with socket.create_server((host, int(port))) as server:
                self._socket, _ = server.accept()
        else:
            self._socket = _dial(host, int(port))
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._received = bytearray(LARGEST)

    def _put(self, buffer: bytearray) -> None:
        length = struct.pack("<I", len(buffer))
        if len(buffer) < 1 << 16:  # in one segment
            self._socket.sendall(length + buffer)
        else:
            self._socket.sendall(length)
            self._socket.sendall(buffer)

    def _get(self) -> memoryview:
        (size,) = struct.unpack("<I", self._fill(4))
        return self._fill(size)

    def _fill(self, size: int) -> memoryview:
        view, count = memoryview(self._received)[:size], 0
        while count < size:
            got = self._socket.recv_into(view[count:])
            if not got:
                raise EOFError("the other end is gone")
            count += got
        return view

    def close(self) -> None:
        self._socket.close()


def _dial(host: str, port: int) -> socket.socket:
    deadline = time.monotonic() + 30.0
    while True:
        try:
            return socket.create_connection((host, port))
        except ConnectionRefusedError:
            if time.monotonic() > deadline:
                raise
            time.sleep(0.01)


ENDS: dict[str, Callable[[str, str, str], End]] = {
    "the bus": BusEnd,
    "the bus, sensor frame": FrameEnd,
    "raw zenoh, recv()": ZenohEnd,
    "raw zenoh, callback": ZenohCallbackEnd,
    "pyzmq": ZmqEnd,
    "raw TCP socket": TcpEnd,
}
