// An MQTT 3.1.1 broker (aedes) behind a relay that misbehaves on purpose.
//
// usage: misbehaving_broker.mjs PORT
// Prints "ready", then a line "message PAYLOAD" for each message on the topic "data" that the broker
// accepted, and "cut" for each connection that it cut. Commands are lines on the standard input:
//   cut N        the next connection ends after N bytes in both directions together
//   drop N       each Nth PUBACK is dropped
//   duplicate N  each Nth PUBACK is sent twice
//   delay N      PUBACKs are sent N ms later
//   reverse N    PUBACKs are sent N at a time, the last first
// N is 0 for the usual behaviour. Each command is answered by a line "set COMMAND".
import net from "node:net";
import readline from "node:readline";
import { Aedes } from "aedes";

const port = Number(process.argv[2]);
const settings = { cut: 0, drop: 0, duplicate: 0, delay: 0, reverse: 0 };
let pubacks = 0;

const broker = await Aedes.createBroker({ maxClientsIdLength: 64 });
broker.on("publish", (packet) => {
    if (packet.topic === "data") console.log(`message ${packet.payload}`);
});
const inner = net.createServer(broker.handle);
await new Promise((done) => inner.listen(0, "127.0.0.1", done));

// Calls back with each whole packet of a stream (MQTT 3.1.1, 2.2.3 Remaining Length).
function packets(each) {
    let rest = Buffer.alloc(0);
    return (bytes) => {
        rest = Buffer.concat([rest, bytes]);
        for (;;) {
            let length = 0, at = 1;
            for (; ; ++at) {
                if (at >= rest.length) return;
                length += (rest[at] & 0x7f) * 128 ** (at - 1);
                if (rest[at] < 0x80) break;
            }
            const end = at + 1 + length;
            if (rest.length < end) return;
            each(rest.subarray(0, end));
            rest = rest.subarray(end);
        }
    };
}

const nth = (n) => n > 0 && pubacks % n === 0;

function relay(client) {
    const server = net.connect(inner.address().port, "127.0.0.1");
    let left = settings.cut || Infinity;
    const held = [];
    settings.cut = 0;
    const end = () => {
        client.destroy();
        server.destroy();
    };
    const pass = (bytes, to) => {
        if (to.destroyed) return;
        to.write(bytes.subarray(0, Math.min(bytes.length, left)), () => {
            if (left <= 0 && !to.reported) {
                to.reported = true;
                console.log("cut");
                end();
            }
        });
        left -= bytes.length;
    };
    const acknowledge = (packet) => {
        ++pubacks;
        if (nth(settings.drop)) return;
        const copies = nth(settings.duplicate) ? [packet, packet] : [packet];
        held.push(Buffer.concat(copies));
        if (held.length < settings.reverse) return;
        for (const bytes of held.splice(0).reverse())
            if (settings.delay) setTimeout(() => pass(bytes, client), settings.delay);
            else pass(bytes, client);
    };
    client.on("data", (bytes) => { if (left > 0) pass(bytes, server); });
    server.on("data", packets((packet) => {
        if (left <= 0) return;
        if (packet[0] >> 4 === 4) acknowledge(packet);
        else pass(packet, client);
    }));
    for (const socket of [client, server]) {
        socket.setNoDelay(true);
        socket.on("error", end);
        socket.on("close", end);
    }
}

readline.createInterface({ input: process.stdin }).on("line", (line) => {
    const [name, value] = line.split(" ");
    settings[name] = Number(value);
    console.log(`set ${line}`);
});
net.createServer(relay).listen(port, "127.0.0.1", () => console.log("ready"));
