// A modbus-serial master that asks what it is asked (talk.js): its methods by their names.
//
// usage: modbus_serial_client.js tcp|telnet PORT UNIT TIMEOUT_MS
//        modbus_serial_client.js rtu|buffered|ascii DEVICE UNIT TIMEOUT_MS
"use strict";
const ModbusRTU = require("modbus-serial");
const talk = require("./talk");

const [kind, endpoint, unit, timeout] = process.argv.slice(2);
const client = new ModbusRTU();
const port = { port: Number(endpoint) };
const line = { baudRate: 19200 };
const connect = {
    tcp: () => client.connectTCP("127.0.0.1", port),
    telnet: () => client.connectTelnet("127.0.0.1", port), // RTU over TCP
    rtu: () => client.connectRTU(endpoint, line),
    buffered: () => client.connectRTUBuffered(endpoint, line),
    ascii: () => client.connectAsciiSerial(endpoint, line),
};

async function ask(method, args) {
    const { buffer, ...result } = await client[method](...args);
    return result;
}

connect[kind]().then(() => {
    client.setID(Number(unit));
    client.setTimeout(Number(timeout));
    return talk(ask, (error) => ({ exception: error.modbusCode, text: error.message }));
});
