// A plugin of QEMU (TCG): the addresses of all stores to peripherals in their order, one in a line of the
// file "stores". Debian has no header of the plugin interface: these are its declarations (QEMU 7.2).
#include <inttypes.h>
#include <stddef.h>
#include <stdio.h>

typedef uint64_t qemu_plugin_id_t;
typedef struct qemu_info_t qemu_info_t;
typedef uint32_t qemu_plugin_meminfo_t;
struct qemu_plugin_tb;
struct qemu_plugin_insn;
typedef void (*block_callback)(qemu_plugin_id_t, struct qemu_plugin_tb *);
typedef void (*memory_callback)(unsigned, qemu_plugin_meminfo_t, uint64_t, void *);
extern void qemu_plugin_register_vcpu_tb_trans_cb(qemu_plugin_id_t, block_callback);
extern size_t qemu_plugin_tb_n_insns(const struct qemu_plugin_tb *);
extern struct qemu_plugin_insn *qemu_plugin_tb_get_insn(const struct qemu_plugin_tb *, size_t);
extern void qemu_plugin_register_vcpu_mem_cb(struct qemu_plugin_insn *, memory_callback, int flags,
                                             int accesses, void *);

int qemu_plugin_version = 1;

static FILE *stores;

static void on_store(unsigned cpu, qemu_plugin_meminfo_t info, uint64_t address, void *data) {
    (void)cpu, (void)info, (void)data;
    if (address >= 0x40000000 && address < 0x60000000) fprintf(stores, "%08" PRIx64 "\n", address);
}

static void on_block(qemu_plugin_id_t id, struct qemu_plugin_tb *block) {
    (void)id;
    enum { NO_REGISTERS = 0, WRITES = 2 };
    for (size_t i = 0; i < qemu_plugin_tb_n_insns(block); ++i)
        qemu_plugin_register_vcpu_mem_cb(qemu_plugin_tb_get_insn(block, i), on_store, NO_REGISTERS, WRITES,
                                         NULL);
}

int qemu_plugin_install(qemu_plugin_id_t id, const qemu_info_t *info, int argc, char **argv) {
    (void)info, (void)argc, (void)argv;
    stores = fopen("stores", "w");
    if (!stores) return 1;
    setlinebuf(stores);
    qemu_plugin_register_vcpu_tb_trans_cb(id, on_block);
    return 0;
}
