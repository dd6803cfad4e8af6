"""The connections of a plant: a link between the program and the broker, and a subscriber.

The link is the witness of what the program has published and what was acknowledged to it. It can hold or cut
the data of either direction.
"""
import json
import select
import socket
import threading
import time
from dataclasses import dataclass, field

CONNECT, PUBLISH, PUBACK, SUBSCRIBE, SUBACK, PINGREQ = 0x10, 0x30, 0x40, 0x82, 0x90, 0xC0
CACHED = 100_000


@dataclass(slots=True)
class Item:
    """A message of the stream: samples (`values` by their number) or a gap; or the birth of a connection."""
    kind: str  # sample, gap, online, other
    first: int = 0
    count: int = 0
    epoch: int = 0
    repeated: bool = False
    gap: dict | None = None
    values: dict = field(default_factory=dict)
    checked: bool = False


def item_of(topic, payload):
    if topic.endswith("/state"):
        return Item("online" if b"online" in payload else "other")
    if not topic.startswith("plant/") and not topic.endswith("/gap"):
        return Item("other")
    body = json.loads(payload)
    repeated = body.get("repeated", False)
    if "gap" in body:
        return Item("gap", body["seq"], body["gap"]["samples"], body["epoch"], repeated, body["gap"])
    if "values" not in body:
        values = {body["seq"]: body}
    else:
        values = {value["seq"]: value | {"variable": name} for name, value in body["values"].items()}
    return Item("sample", min(values), len(values), body["epoch"], repeated, values=values)


def varint(data, at):
    """The number at an offset and the offset behind it; None: it is not complete."""
    number = shift = 0
    for at in range(at, len(data)):
        number |= (data[at] & 0x7F) << shift
        shift += 7
        if data[at] < 0x80:
            return number, at + 1
    return None


class PacketStream:
    """Splits bytes into MQTT packets: (first byte, body)."""

    def __init__(self):
        self.buffer = bytearray()

    def feed(self, data):
        self.buffer += data
        packets, at = [], 0
        while length := varint(self.buffer, at + 1):
            size, body = length
            if body + size > len(self.buffer):
                break
            packets.append((self.buffer[at], bytes(self.buffer[body:body + size])))
            at = body + size
        del self.buffer[:at]
        return packets


def split_publish(first, body, version):
    """(topic, packet identifier or None, payload)"""
    at = 2 + int.from_bytes(body[:2], "big")
    topic, identifier = body[2:at].decode(), None
    if first & 6:
        identifier = int.from_bytes(body[at:at + 2], "big")
        at += 2
    if version == 5:
        properties, at = varint(body, at)
        at += properties
    return topic, identifier, body[at:]


class Pair:
    """A connection of the program and the one to the broker that belongs to it."""

    def __init__(self, run, client, broker):
        self.run, self.client, self.broker = run, client, broker
        self.up, self.down = PacketStream(), PacketStream()
        self.held_up, self.held_down = bytearray(), bytearray()
        self.version = 4
        self.in_flight = {}


class Wire(threading.Thread):
    """One thread for both. `mode`: pass, hold_up, hold_down, away. `cut_after`: the connection is closed when
    so many more bytes were passed on to the broker; None: never."""

    def __init__(self, broker_port):
        super().__init__(daemon=True)
        self.broker_port = broker_port
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.port = self.listener.getsockname()[1]
        self.run_number = 0
        self.mode, self.cut_after = "pass", None
        self.acknowledged_to = 0  # the number of the last sample acknowledged in the newest run
        self.events = []  # ("connect" | "publish" | "acknowledge", run, item), in the order of the link
        self.received = []  # of the subscriber
        self.subscribed = False
        self.subscriber_away = 0.0  # seconds from the loss of the subscriber's connection to its next attempt
        self.ended = False
        self.failure = None
        self.pairs = []
        self._cache = {}
        self._subscriber, self._packets, self._again = None, PacketStream(), 0.0

    def begin_run(self):
        self.run_number += 1
        self.acknowledged_to = 0

    def idle(self):
        """The program has no connection, and all that it sent was seen."""
        if self.failure:
            raise self.failure
        return not self.pairs and not select.select([self.listener], [], [], 0)[0]

    def run(self):
        try:
            while not self.ended:
                self._turn()
        except Exception as error:  # idle() raises it on the other thread
            self.failure = error
        for pair in list(self.pairs):
            self._close(pair)
        self.listener.close()
        if self._subscriber:
            self._subscriber.close()

    def _turn(self):
        if self._subscriber is None and time.monotonic() >= self._again:
            self._connect_subscriber()
        by_socket = {pair.client: (pair, self._from_client) for pair in self.pairs}
        by_socket |= {pair.broker: (pair, self._from_broker) for pair in self.pairs}
        sockets = [self.listener, *by_socket] + ([self._subscriber] if self._subscriber else [])
        for ready in select.select(sockets, [], [], 0.005)[0]:
            if ready is self.listener:
                self._accept()
            elif ready is self._subscriber:
                self._from_subscription()
            elif by_socket[ready][0] in self.pairs:
                pair, handle = by_socket[ready]
                try:
                    handle(pair)
                except OSError:
                    self._close(pair)
        if self.mode in ("pass", "away"):
            for pair in list(self.pairs):
                try:
                    (self._release if self.mode == "pass" else self._close)(pair)
                except OSError:
                    self._close(pair)

    def _accept(self):
        client, _ = self.listener.accept()
        client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        try:
            if self.mode == "away":
                raise OSError
            broker = socket.create_connection(("127.0.0.1", self.broker_port), timeout=100)
        except OSError:
            client.close()
            return
        broker.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        client.settimeout(100)
        self.pairs.append(Pair(self.run_number, client, broker))
        self.events.append(("connect", self.run_number, None))

    def _close(self, pair):
        if pair in self.pairs:
            self.pairs.remove(pair)
        pair.client.close()
        pair.broker.close()

    def _from_client(self, pair):
        data = pair.client.recv(1 << 16)
        if not data:
            self._close(pair)
            return
        for first, body in pair.up.feed(data):
            if first == CONNECT:
                pair.version = body[6]
            elif first & 0xF0 == PUBLISH:
                topic, identifier, payload = split_publish(first, body, pair.version)
                item = self._item(topic, payload)
                self.events.append(("publish", pair.run, item))
                if identifier is not None:
                    pair.in_flight[identifier] = item
        pair.held_up += data
        if self.mode != "hold_up":
            self._pass_up(pair)

    def _pass_up(self, pair):
        data, pair.held_up = bytes(pair.held_up), bytearray()
        if self.cut_after is not None and len(data) >= self.cut_after:
            pair.broker.sendall(data[:self.cut_after])
            self.cut_after = None
            self._close(pair)
            return
        if self.cut_after is not None:
            self.cut_after -= len(data)
        if data:
            pair.broker.sendall(data)

    def _from_broker(self, pair):
        data = pair.broker.recv(1 << 16)
        if not data:
            self._close(pair)
            return
        pair.held_down += data
        if self.mode != "hold_down":
            self._pass_down(pair)

    def _pass_down(self, pair):
        data, pair.held_down = bytes(pair.held_down), bytearray()
        for first, body in pair.down.feed(data):
            if first == PUBACK and (len(body) < 3 or body[2] < 0x80):
                item = pair.in_flight.pop(int.from_bytes(body[:2], "big"), Item("other"))
                self.events.append(("acknowledge", pair.run, item))
                if pair.run == self.run_number and item.kind in ("sample", "gap"):
                    self.acknowledged_to = item.first + item.count - 1
        if data:
            pair.client.sendall(data)

    def _release(self, pair):
        if pair.held_up:
            self._pass_up(pair)
        if pair.held_down and pair in self.pairs:
            self._pass_down(pair)

    def _item(self, topic, payload):
        if len(self._cache) > CACHED:
            self._cache.clear()
        item = self._cache[payload] = item_of(topic, payload)
        return item

    def _connect_subscriber(self):
        try:
            self._subscriber = socket.create_connection(("127.0.0.1", self.broker_port), timeout=100)
            name = b"subscriber"
            body = b"\0\4MQTT\4\2\0\0" + len(name).to_bytes(2, "big") + name
            filters = b"\0\1" + b"\0\1#\1"
            self._subscriber.sendall(
                bytes((CONNECT, len(body))) + body + bytes((SUBSCRIBE, len(filters))) + filters)
        except OSError:
            self._drop_subscriber()
        self._packets = PacketStream()

    def _drop_subscriber(self):
        self.subscribed = False
        if self._subscriber:
            self._subscriber.close()
        self._subscriber = None
        self._again = time.monotonic() + max(0.01, self.subscriber_away)
        self.received.append(Item("online"))  # the order begins anew

    def _from_subscription(self):
        try:
            data = self._subscriber.recv(1 << 16)
            if not data:
                return self._drop_subscriber()
            acknowledgements = bytearray()
            for first, body in self._packets.feed(data):
                if first == SUBACK:
                    self.subscribed = True
                if first & 0xF0 != PUBLISH:
                    continue
                topic, identifier, payload = split_publish(first, body, 4)
                if identifier is not None:
                    acknowledgements += bytes((PUBACK, 2)) + identifier.to_bytes(2, "big")
                if not first & 1:  # not a retained message of an earlier connection
                    self.received.append(self._cache.get(payload) or item_of(topic, payload))
            self._subscriber.sendall(acknowledgements)
        except OSError:
            self._drop_subscriber()
        return None
