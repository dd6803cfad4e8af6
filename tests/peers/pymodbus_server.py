"""A pymodbus slave with 10000 of each area, filled with the ramp (register a holds a, bit a holds a & 1).

usage: pymodbus_server.py tcp PORT UNIT [identity] | pymodbus_server.py rtu|ascii DEVICE UNIT
Prints "ready" when it can be asked; runs until it is killed.
"""
import asyncio
import sys

from pymodbus.device import ModbusDeviceIdentification
from pymodbus.datastore import ModbusSequentialDataBlock, ModbusServerContext, ModbusSlaveContext
from pymodbus.server.async_io import ModbusSerialServer, ModbusTcpServer
from pymodbus.transaction import ModbusAsciiFramer, ModbusRtuFramer

COUNT = 10000


def ramp(unit):
    bits = [bool(a & 1) for a in range(COUNT)]
    registers = list(range(COUNT))
    blocks = {"co": bits, "di": bits, "hr": registers, "ir": registers}
    slave = ModbusSlaveContext(zero_mode=True,
                               **{k: ModbusSequentialDataBlock(0, list(v))
                                  for k, v in blocks.items()})
    return ModbusServerContext(slaves={unit: slave}, single=False)


IDENTITY = {0: "Acme", 1: "T1", 2: "1.0", 5: "Model M"}


async def main(kind, endpoint, unit, *identity):
    context = ramp(int(unit))
    if kind == "tcp":
        server = ModbusTcpServer(context, address=("127.0.0.1", int(endpoint)), allow_reuse_address=True,
                                 identity=ModbusDeviceIdentification(info=IDENTITY) if identity else None)
        task = asyncio.create_task(server.serve_forever())
        await server.serving
    else:
        framer = ModbusRtuFramer if kind == "rtu" else ModbusAsciiFramer
        server = ModbusSerialServer(context, framer, port=endpoint, baudrate=19200, parity="N", timeout=0.05,
                                    ignore_missing_slaves=True)
        await server.start()
        task = asyncio.create_task(server.serve_forever())
    print("ready", flush=True)
    await task


asyncio.run(main(*sys.argv[1:]))
