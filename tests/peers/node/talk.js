// A peer's conversation with a test: requests as JSON lines on standard input, [method, argument…], one at a
// time; for each a line on standard output, {"result": …} or {"error": …}. "ready" comes first; the end of
// the input ends the peer.
"use strict";
const readline = require("readline");

module.exports = async function talk(ask, error_json) {
    const lines = readline.createInterface({ input: process.stdin });
    console.log("ready");
    for await (const line of lines) {
        const [method, ...args] = JSON.parse(line);
        let answer;
        try {
            answer = { result: await ask(method, args) };
        } catch (error) {
            answer = { error: error_json(error) };
        }
        console.log(JSON.stringify(answer));
    }
    process.exit(0);
};
