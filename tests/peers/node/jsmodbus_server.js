// A jsmodbus slave with 10000 of each area, filled with the ramp (register a has a, bit a has a & 1). It has
// no unit of its own.
// Prints "ready" when it can be asked; runs until it is killed.
//
// usage: jsmodbus_server.js tcp PORT | jsmodbus_server.js rtu DEVICE
"use strict";
const net = require("net");
const { ModbusRTUResponse, ModbusTCPResponse, responses, server } = require("jsmodbus");
const { SerialPort } = require("serialport");

const [kind, endpoint] = process.argv.slice(2);
const COUNT = 10000;
const bits = () => Buffer.alloc(COUNT / 8, 0xaa);
const registers = () => Buffer.from(Uint16Array.from({ length: COUNT }, (_, a) => a).buffer).swap16();
const ready = () => console.log("ready");

const serial_port = () => new SerialPort({ path: endpoint, baudRate: 19200 }, ready);
const socket = kind === "tcp" ? net.createServer() : serial_port();
const areas = { coils: bits(), discrete: bits(), holding: registers(), input: registers() };
const slave = new server[kind.toUpperCase()](socket, areas);

const TEXTS = { 0: "Acme", 1: "T1", 2: "1.0", 5: "Model M" };
const OBJECTS = Object.entries(TEXTS).map(([id, text]) => ({ id: Number(id), value: Buffer.from(text) }));
slave.on("readDeviceIdentification", (request, answer) => {
    const code = request.body.readDeviceIdCode;
    const body = new responses.ReadDeviceIdentificationResponseBody(code, 0x82, 0, 0, OBJECTS);
    const response = kind === "tcp" ? ModbusTCPResponse : ModbusRTUResponse;
    answer(response.fromRequest(request, body).createPayload());
});
if (kind === "tcp") socket.listen(Number(endpoint), "127.0.0.1", ready);
