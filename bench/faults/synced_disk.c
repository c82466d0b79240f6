/* Stands in for fsync() of a program that is started with LD_PRELOAD: whatever is synced is also copied
   to the folder SYNCED_DISK, from which power.py makes what a disk holds after a loss of power. A file's
   content goes to SYNCED_DISK/I, the names of a folder to SYNCED_DISK/names.I; I is the inode. */
#define _GNU_SOURCE
#include <dirent.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

static void copy_content(int from, FILE* to) {
  char block[65536];
  off_t at = 0;
  for (ssize_t n; (n = pread(from, block, sizeof block, at)) > 0; at += n) fwrite(block, 1, n, to);
}

static void copy_names(const char* folder, FILE* to) {
  DIR* open = opendir(folder);
  for (struct dirent* entry; open && (entry = readdir(open));)
    if (entry->d_type == DT_REG) fprintf(to, "%lu %s\n", (unsigned long)entry->d_ino, entry->d_name);
  if (open) closedir(open);
}

int fsync(int file) {
  const char* disk = getenv("SYNCED_DISK");
  char descriptor[64], path[4096], made[4096], done[4096];
  struct stat status;
  snprintf(descriptor, sizeof descriptor, "/proc/self/fd/%d", file);
  const ssize_t length = readlink(descriptor, path, sizeof path - 1);
  if (disk && length > 0 && fstat(file, &status) == 0) {
    path[length] = 0;
    const int is_folder = S_ISDIR(status.st_mode);
    snprintf(made, sizeof made, "%s/making.%d", disk, (int)getpid());
    snprintf(done, sizeof done, "%s/%s%lu", disk, is_folder ? "names." : "",
             (unsigned long)status.st_ino);
    FILE* to = fopen(made, "wb");
    const int from = is_folder ? -1 : open(path, O_RDONLY);
    if (to && is_folder) copy_names(path, to);
    if (to && from >= 0) copy_content(from, to);
    if (from >= 0) close(from);
    if (to && fclose(to) == 0) rename(made, done);
  }
  return (int)syscall(SYS_fsync, file);
}
