// The annotations of Microsoft's compilers that DirectXMath uses, as nothing: other compilers have no sal.h.
#pragma once

#define _Analysis_assume_(e)
#define _In_
#define _In_opt_
#define _In_range_(a, b)
#define _In_reads_(n)
#define _In_reads_bytes_(n)
#define _In_reads_bytes_opt_(n)
#define _In_reads_opt_(n)
#define _Inout_
#define _Inout_updates_all_(n)
#define _Inout_updates_bytes_(n)
#define _Out_
#define _Out_opt_
#define _Out_writes_(n)
#define _Out_writes_bytes_(n)
#define _Out_writes_bytes_opt_(n)
#define _Out_writes_bytes_to_(n, m)
#define _Out_writes_opt_(n)
#define _Out_writes_to_(n, m)
#define _Outptr_
#define _Ret_maybenull_
#define _Success_(e)
#define _Use_decl_annotations_
#define _When_(e, a)
