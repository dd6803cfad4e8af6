// A jsmodbus master that asks what it is asked (talk.js): its methods by their names.
//
// usage: jsmodbus_client.js tcp PORT UNIT TIMEOUT_MS | jsmodbus_client.js rtu DEVICE UNIT TIMEOUT_MS
"use strict";
const net = require("net");
const { client } = require("jsmodbus");
const { SerialPort } = require("serialport");
const talk = require("./talk");

const [kind, endpoint, unit, timeout] = process.argv.slice(2);
const socket = kind === "tcp" ? new net.Socket() : new SerialPort({ path: endpoint, baudRate: 19200 });
const master = new client[kind.toUpperCase()](socket, Number(unit), Number(timeout));

async function ask(method, args) {
    const { body } = (await master[method](...args)).response;
    if (body.objects)
        return Object.fromEntries(body.objects.map((object) => [object.id, object.value.toString()]));
    if (body.valuesAsArray) return Array.from(body.valuesAsArray);
    return { address: body.address ?? body.start, value: body.value ?? body.quantity };
}

function error_json(error) {
    const exception = error.err === "ModbusException" ? error.response.body.code : undefined;
    return { exception, text: error.message };
}

socket.on(kind === "tcp" ? "connect" : "open", () => talk(ask, error_json));
if (kind === "tcp") socket.connect(Number(endpoint), "127.0.0.1");
