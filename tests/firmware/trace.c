// A plugin of QEMU (TCG) that writes lines of the file "trace". With the option stores=on: the addresses of
// all stores to peripherals in their order. With at=ADDRESS, several times: whenever the instruction at that
// address is executed, the address, the instructions executed so far, and those of them that were WFI.
// Debian has no header of the plugin interface: these are its declarations (QEMU 7.2).
#include <inttypes.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef uint64_t qemu_plugin_id_t;
typedef struct qemu_info_t qemu_info_t;
typedef uint32_t qemu_plugin_meminfo_t;
struct qemu_plugin_tb;
struct qemu_plugin_insn;
typedef void (*block_callback)(qemu_plugin_id_t, struct qemu_plugin_tb*);
typedef void (*memory_callback)(unsigned, qemu_plugin_meminfo_t, uint64_t, void*);
typedef void (*instruction_callback)(unsigned, void*);
extern void qemu_plugin_register_vcpu_tb_trans_cb(qemu_plugin_id_t, block_callback);
extern size_t qemu_plugin_tb_n_insns(const struct qemu_plugin_tb*);
extern struct qemu_plugin_insn* qemu_plugin_tb_get_insn(const struct qemu_plugin_tb*, size_t);
extern const void* qemu_plugin_insn_data(const struct qemu_plugin_insn*);
extern uint64_t qemu_plugin_insn_vaddr(const struct qemu_plugin_insn*);
extern void qemu_plugin_register_vcpu_mem_cb(struct qemu_plugin_insn*, memory_callback, int flags,
                                             int accesses, void*);
extern void qemu_plugin_register_vcpu_insn_exec_cb(struct qemu_plugin_insn*, instruction_callback, int flags,
                                                   void*);
extern void qemu_plugin_register_vcpu_insn_exec_inline(struct qemu_plugin_insn*, int operation, void*,
                                                       uint64_t);

int qemu_plugin_version = 1;

enum { NO_REGISTERS = 0, WRITES = 2, ADD = 0, MOST_MARKS = 8 };

static FILE* trace;
static int with_stores;
static uint64_t marks[MOST_MARKS];
static size_t mark_count;
static uint64_t instructions, waits;

static void on_store(unsigned cpu, qemu_plugin_meminfo_t info, uint64_t address, void* data) {
    (void)cpu, (void)info, (void)data;
    if (address >= 0x40000000 && address < 0x60000000) fprintf(trace, "%08" PRIx64 "\n", address);
}

static void on_mark(unsigned cpu, void* mark) {
    (void)cpu;
    fprintf(trace, "%08" PRIx64 " %" PRIu64 " %" PRIu64 "\n", *(const uint64_t*)mark, instructions, waits);
}

static void on_instruction(struct qemu_plugin_insn* instruction) {
    static const unsigned char WFI[] = {0x30, 0xBF};
    if (with_stores) qemu_plugin_register_vcpu_mem_cb(instruction, on_store, NO_REGISTERS, WRITES, NULL);
    qemu_plugin_register_vcpu_insn_exec_inline(instruction, ADD, &instructions, 1);
    if (memcmp(qemu_plugin_insn_data(instruction), WFI, sizeof WFI) == 0)
        qemu_plugin_register_vcpu_insn_exec_inline(instruction, ADD, &waits, 1);
    for (size_t i = 0; i < mark_count; ++i)
        if (qemu_plugin_insn_vaddr(instruction) == marks[i])
            qemu_plugin_register_vcpu_insn_exec_cb(instruction, on_mark, NO_REGISTERS, &marks[i]);
}

static void on_block(qemu_plugin_id_t id, struct qemu_plugin_tb* block) {
    (void)id;
    for (size_t i = 0; i < qemu_plugin_tb_n_insns(block); ++i)
        on_instruction(qemu_plugin_tb_get_insn(block, i));
}

int qemu_plugin_install(qemu_plugin_id_t id, const qemu_info_t* info, int argc, char** argv) {
    (void)info;
    for (int i = 0; i < argc; ++i) {
        if (strcmp(argv[i], "stores=on") == 0) with_stores = 1;
        if (strncmp(argv[i], "at=", 3) == 0 && mark_count < MOST_MARKS)
            marks[mark_count++] = strtoull(argv[i] + 3, NULL, 16);
    }
    trace = fopen("trace", "w");
    if (!trace) return 1;
    setlinebuf(trace);
    qemu_plugin_register_vcpu_tb_trans_cb(id, on_block);
    return 0;
}
