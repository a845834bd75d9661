/* A Vulkan layer that loses devices on cue. From the LOSE_AT-th wait for a device on, counted from 1, each wait returns
   VK_ERROR_DEVICE_LOST after the driver has finished it, also if it timed out. With LOSE_ON_CLOSE, vkQueueWaitIdle,
   which wgpu calls to close a device, returns VK_ERROR_OUT_OF_DEVICE_MEMORY, whether or not the device was lost. Only
   the first LOSE_DEVICES devices are affected. It serves one driver at a time. The few declarations of Vulkan's
   interface that it needs are written out, so that no headers have to be installed. */
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

typedef int32_t Result;
typedef void *Handle;
typedef void (*Function)(void);
typedef Function (*GetProcAddr)(Handle, const char *);

#define OUT_OF_DEVICE_MEMORY (-2)
#define DEVICE_LOST (-4)
#define INITIALIZATION_FAILED (-3)

/* How the loader hands over what comes after this layer. */
typedef struct Link {
    struct Link *next;
    GetProcAddr instance_proc_addr;
    GetProcAddr device_proc_addr;
} Link;
typedef struct LoaderInfo {
    int32_t type;
    struct LoaderInfo *next;
    int32_t function;
    Link *link;
} LoaderInfo;
enum { INSTANCE_INFO = 47, DEVICE_INFO = 48 };

typedef struct {
    int32_t type;
    void *next;
    uint32_t version;
    GetProcAddr instance_proc_addr, device_proc_addr, physical_device_proc_addr;
} Negotiation;

typedef Result (*CreateInstance)(const LoaderInfo *, const void *, Handle *);
typedef Result (*CreateDevice)(Handle, const LoaderInfo *, const void *, Handle *);
typedef Result (*WaitSemaphores)(Handle, const void *, uint64_t);
typedef Result (*WaitFences)(Handle, uint32_t, const void *, uint32_t, uint64_t);
typedef Result (*WaitIdle)(Handle);

static GetProcAddr next_instance, next_device;
static WaitSemaphores next_wait_semaphores;
static WaitFences next_wait_fences;
static WaitIdle next_wait_idle;
static Handle instance_of_all;
static int devices, waits;

static int number(const char *name) {
    const char *text = getenv(name);
    return text ? atoi(text) : 0;
}

/* Whether a wait that has ended is the one at which the device is lost, or comes after it. */
static int is_lost(void) {
    return devices <= number("LOSE_DEVICES") && __sync_add_and_fetch(&waits, 1) >= number("LOSE_AT");
}

static Result wait_semaphores(Handle device, const void *info, uint64_t timeout) {
    Result result = next_wait_semaphores(device, info, timeout);
    return is_lost() ? DEVICE_LOST : result;
}

static Result wait_fences(Handle device, uint32_t count, const void *fences, uint32_t all, uint64_t timeout) {
    Result result = next_wait_fences(device, count, fences, all, timeout);
    return is_lost() ? DEVICE_LOST : result;
}

static Result wait_idle(Handle queue) {
    Result result = next_wait_idle(queue);
    return number("LOSE_ON_CLOSE") && devices <= number("LOSE_DEVICES") ? OUT_OF_DEVICE_MEMORY : result;
}

static LoaderInfo *link_of(const LoaderInfo *create, int32_t type) {
    LoaderInfo *info = create->next;
    while (info && (info->type != type || info->function != 0)) info = info->next;
    return info;
}

static Result create_instance(const LoaderInfo *create, const void *allocator, Handle *instance) {
    LoaderInfo *info = link_of(create, INSTANCE_INFO);
    if (!info) return INITIALIZATION_FAILED;
    next_instance = info->link->instance_proc_addr;
    info->link = info->link->next;
    Result result = ((CreateInstance)next_instance(NULL, "vkCreateInstance"))(create, allocator, instance);
    if (result == 0) instance_of_all = *instance;
    return result;
}

static Result create_device(Handle adapter, const LoaderInfo *create, const void *allocator, Handle *device) {
    LoaderInfo *info = link_of(create, DEVICE_INFO);
    if (!info) return INITIALIZATION_FAILED;
    GetProcAddr instance = info->link->instance_proc_addr;
    next_device = info->link->device_proc_addr;
    info->link = info->link->next;
    Result result = ((CreateDevice)instance(instance_of_all, "vkCreateDevice"))(adapter, create, allocator, device);
    if (result == 0) {
        __sync_add_and_fetch(&devices, 1);
        __sync_and_and_fetch(&waits, 0);
    }
    return result;
}

static Function device_proc_addr(Handle device, const char *name) {
    Function next = next_device(device, name);
    if (next && (!strcmp(name, "vkWaitSemaphores") || !strcmp(name, "vkWaitSemaphoresKHR"))) {
        next_wait_semaphores = (WaitSemaphores)next;
        return (Function)wait_semaphores;
    }
    if (next && !strcmp(name, "vkWaitForFences")) {
        next_wait_fences = (WaitFences)next;
        return (Function)wait_fences;
    }
    if (next && !strcmp(name, "vkQueueWaitIdle")) {
        next_wait_idle = (WaitIdle)next;
        return (Function)wait_idle;
    }
    return next;
}

static Function instance_proc_addr(Handle instance, const char *name) {
    if (!strcmp(name, "vkCreateInstance")) return (Function)create_instance;
    if (!strcmp(name, "vkCreateDevice")) return (Function)create_device;
    if (!strcmp(name, "vkGetDeviceProcAddr")) return (Function)device_proc_addr;
    return next_instance ? next_instance(instance, name) : NULL;
}

Result vkNegotiateLoaderLayerInterfaceVersion(Negotiation *with) {
    with->version = 2;
    with->instance_proc_addr = instance_proc_addr;
    with->device_proc_addr = device_proc_addr;
    with->physical_device_proc_addr = NULL;
    return 0;
}
