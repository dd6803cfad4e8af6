/** "1 row", "2 rows" */
export const of = (n: number | string, one: string): string => `${n} ${one}${String(n) === '1' ? '' : 's'}`;
