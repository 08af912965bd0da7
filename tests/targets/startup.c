/* Start of a program on the Cortex-M4 that QEMU emulates, with semihosting. */
#include <stdlib.h>

extern void initialise_monitor_handles(void);
extern int main(void);

void Reset_Handler(void) {
    *(volatile unsigned *)0xE000ED88 |= 0xF << 20; /* the unit for float32 is switched on */
    __asm volatile("dsb; isb");
    initialise_monitor_handles();
    exit(main());
}

__attribute__((section(".vectors"), used)) void *vectors[] = {(void *)0x20300000, (void *)Reset_Handler};
void _init(void) {}
void _fini(void) {}
