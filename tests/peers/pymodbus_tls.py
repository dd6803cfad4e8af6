"""A TLS server on a port, and one request to the server on another: FOLDER OWN-PORT OTHER-PORT."""
import asyncio
import pathlib
import ssl
import sys

from pymodbus.client import AsyncModbusTlsClient
from pymodbus.datastore import ModbusSequentialDataBlock, ModbusServerContext, ModbusSlaveContext
from pymodbus.framer.socket_framer import ModbusSocketFramer
from pymodbus.server import StartAsyncTlsServer

FOLDER = pathlib.Path(sys.argv[1])


def context(kind, folder, name):
    made = ssl.SSLContext(kind)
    made.load_verify_locations(FOLDER / "root.pem")
    made.check_hostname = kind == ssl.PROTOCOL_TLS_CLIENT
    made.verify_mode = ssl.CERT_REQUIRED
    made.load_cert_chain(FOLDER / folder / f"{name}.pem", FOLDER / folder / f"{name}.key")
    return made


async def main():
    # The framer of Modbus TCP: that of pymodbus for TLS sends no MBAP header (against R-05).
    block = ModbusSequentialDataBlock(0, [7] * 100)
    store = ModbusServerContext(slaves=ModbusSlaveContext(hr=block, zero_mode=True), single=True)
    server = asyncio.create_task(
        StartAsyncTlsServer(context=store,
                            framer=ModbusSocketFramer,
                            address=("127.0.0.1", int(sys.argv[2])),
                            sslctx=context(ssl.PROTOCOL_TLS_SERVER, "server", "server")))
    await asyncio.sleep(0.5)
    client = AsyncModbusTlsClient("127.0.0.1",
                                  port=int(sys.argv[3]),
                                  framer=ModbusSocketFramer,
                                  sslctx=context(ssl.PROTOCOL_TLS_CLIENT, "operator", "client"),
                                  server_hostname="localhost",
                                  timeout=5)
    await client.connect()
    answer = await client.protocol.read_holding_registers(0, 2, slave=1)
    print(answer if answer.isError() else answer.registers, flush=True)
    await server


asyncio.run(main())
