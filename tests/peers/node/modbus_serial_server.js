// A modbus-serial slave with 10000 of each area, filled with the ramp: register a has a, bit a has a & 1.
// Prints "ready" when it can be asked; runs until it is killed.
//
// usage: modbus_serial_server.js tcp PORT UNIT | modbus_serial_server.js rtu DEVICE UNIT
"use strict";
const { ServerSerial, ServerTCP } = require("modbus-serial");

const [kind, endpoint, unit] = process.argv.slice(2);
const COUNT = 10000;
const ramp = (of) => Array.from({ length: COUNT }, (_, a) => of(a));
const odd = (a) => (a & 1) === 1;
const same = (a) => a;
const areas = { coils: ramp(odd), discrete: ramp(odd), holding: ramp(same), input: ramp(same) };

function there(address) {
    if (address >= COUNT) throw Object.assign(new Error("no such item"), { modbusErrorCode: 2 });
    return address;
}
const get = (area) => (address) => areas[area][there(address)];
const set = (area) => (address, value) => { areas[area][there(address)] = value; };

const vector = {
    getCoil: get("coils"),
    getDiscreteInput: get("discrete"),
    getHoldingRegister: get("holding"),
    getInputRegister: get("input"),
    setCoil: set("coils"),
    setRegister: set("holding"),
    reportServerID: () => ({ id: 0x42, running: true, additionalData: Buffer.from("pump") }),
    readDeviceIdentification: () => ({ 0: "Acme", 1: "T1", 2: "1.0", 5: "Model M" }),
};

const server = kind === "tcp"
    ? new ServerTCP(vector, { host: "127.0.0.1", port: Number(endpoint), unitID: Number(unit) })
    : new ServerSerial(vector, { path: endpoint, baudRate: 19200, unitID: Number(unit) });
server.on("initialized", () => console.log("ready"));
