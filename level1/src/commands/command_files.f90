!> gracecg level1 list, dump, convert, check: what Level-1 files hold.
module gracecg_level1_command_files
    use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
    use gracecg_cli_work
    use gracecg_files_file, only: directory_exists
    use gracecg_level1_bundles, only: find_level1_files, is_bundle
    use gracecg_level1_check, only: level1_check_t, check_level1
    use gracecg_level1_command_estimate, only: add_day_options, MOST_PLACES, PLACES_ARE
    use gracecg_level1_conversion, only: exchange_level1, FORMS
    use gracecg_level1_folder, only: level1_folder_t, open_level1_folder
    use gracecg_level1_header, only: product_of_file_name, date_of_file_name, name_of
    use gracecg_level1_products, only: KIND_LETTER, KIND_F4, KIND_F8
    use gracecg_level1_reader, only: level1_reader_t, level1_block_t
    use gracecg_level1_summary, only: level1_summary_t, field_summary_t, summarise_level1, GAP_INTERVALS
    use gracecg_level1_time, only: gps_date_text
    implicit none
    private
    public :: declare_level1_list, run_level1_list, declare_level1_dump, run_level1_dump, declare_level1_convert, &
        run_level1_convert, declare_level1_check, run_level1_check

    character(*), parameter :: ACC = 'ACC1A_2023-06-01_C_04.txt'

    character(7), parameter :: DUMP_FORMATS(2) = [character(7) :: 'csv', 'records']

contains

    !> Arguments and help of `gracecg level1 list`.
    subroutine declare_level1_list(arguments)
        type(arguments_t), intent(inout) :: arguments

        call arguments%describe('level1 list', 'FILE ...', 1, MOST_PLACES, &
                                'Shows what Level-1 files of GRACE and GRACE-FO hold, text or binary: product, satellite, '// &
                                'records, first and last time, mean interval, gaps (steps longer than 1.5 usual ones), how '// &
                                'many records have each bit of the quality flag set, and what is unusual. A folder, '// &
                                'and a bundle (.tgz, .tar), stands for the Level-1 files in it.', &
                                'gracecg level1 list '//ACC)
        call add_format_option(arguments)
    end subroutine declare_level1_list

    !> The work of `gracecg level1 list`.
    subroutine run_level1_list(arguments, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: misuse, error

        type(string_t), allocatable :: paths(:), failures(:)
        type(level1_summary_t), allocatable :: summaries(:)
        type(data_table_t) :: table
        type(results_t) :: results
        integer :: i, n

        call take_format(arguments, console, misuse)
        if (allocated(misuse)) return
        call level1_paths(arguments, paths, error)
        if (allocated(error)) return
        allocate (failures(0), summaries(size(paths)))
        call declare_columns(table)
        n = 0
        do i = 1, size(paths)
            call summarise_level1(paths(i)%text, summaries(n + 1), error, with_fields=.false.)
            if (allocated(error)) then
                call append(failures, error%message)
                deallocate (error)
                cycle
            end if
            n = n + 1
            call tell_joint(summaries(:n - 1), summaries(n))
            call add_row(table, summaries(n))
            call tell_warnings(paths(i)%text, summaries(n)%warnings, console)
        end do
        call console%table(table)
        call results%open('level1 list')
        call results%publish(table, console, error)
        if (size(failures) > 0 .and. .not. allocated(error)) &
            call fail(error, join(padded(failures), new_line('a')))
    end subroutine run_level1_list

    !> Notes whether a file goes on where the one before it, of the same product and satellite and another day, ends:
    !> with a gap, or overlapping, so that records may be there twice.
    subroutine tell_joint(before, summary)
        type(level1_summary_t), intent(in) :: before(:)
        type(level1_summary_t), intent(inout) :: summary

        real(dp), parameter :: NEXT = 86400     ! s: a file that begins later is of no day behind
        character(9) :: size_text
        real(dp) :: step
        integer :: i

        if (summary%records == 0 .or. summary%layout%is_event .or. summary%interval <= 0) return
        do i = size(before), 1, -1
            if (before(i)%layout%product == summary%layout%product .and. before(i)%satellite == summary%satellite .and. &
                before(i)%records > 0) exit
        end do
        if (i == 0) return
        if (date_of_file_name(summary%path) <= date_of_file_name(before(i)%path)) return
        step = real(summary%first_seconds - before(i)%last_seconds, dp) + &
            (summary%first_fraction - before(i)%last_fraction)
        write (size_text, '(f9.1)') abs(step)
        if (step > GAP_INTERVALS*summary%interval .and. step < NEXT) then
            call append(summary%warnings, 'begins '//trim(adjustl(size_text))//' s behind the last record of '// &
                        name_of(before(i)%path)//': a gap')
        else if (step <= 0) then
            call append(summary%warnings, 'begins '//trim(adjustl(size_text))//' s before the last record of '// &
                        name_of(before(i)%path)//': they overlap, and records of equal epochs are used once')
        end if
    end subroutine tell_joint

    !> The files of the arguments; of folders and bundles those that are named like Level-1 files.
    subroutine level1_paths(arguments, paths, error)
        type(arguments_t), intent(in) :: arguments
        type(string_t), allocatable, intent(out) :: paths(:)
        type(error_t), allocatable, intent(out) :: error

        type(string_t), allocatable :: found(:)
        integer :: i, k, before

        allocate (paths(0))
        do i = 1, arguments%positional_count()
            found = [string_t ::]
            before = size(paths)
            associate (place => arguments%words(i)%text)
                if (.not. (directory_exists(place) .or. is_bundle(place))) then
                    call append(paths, place)
                    cycle
                end if
                call find_level1_files(place, found, error)
                if (allocated(error)) return
                do k = 1, size(found)
                    if (product_of_file_name(found(k)%text) /= '') call append(paths, found(k)%text)
                end do
                if (size(paths) == before) call fail(error, place//': no Level-1 file in it; their names are like '//ACC)
                if (allocated(error)) return
            end associate
        end do
    end subroutine level1_paths

    subroutine declare_columns(table)
        type(data_table_t), intent(inout) :: table

        integer :: bit

        call table%column('file', 'a', 'file')
        call table%columns_of('product,satellite,format')
        call table%column('records', 'i0', 'records')
        call table%columns_of('first,last')
        call table%column('first_date', 'a', 'first (GPS)')
        call table%column('last_date')
        call table%column('interval_s', 'f12.6', 'interval|s')
        call table%column('gaps', 'i0', 'gaps')
        call table%column('duplicates', 'i0', 'dou-|ble')
        call table%column('unsorted', 'i0', 'un-|sorted')
        do bit = 0, 7
            call table%column('bit_'//integer_text(bit))
        end do
        call table%column('flags', 'a', 'flags|bit:records')
        call table%column('warnings')
    end subroutine declare_columns

    subroutine add_row(table, summary)
        type(data_table_t), intent(inout) :: table
        type(level1_summary_t), intent(in) :: summary

        character(:), allocatable :: flags
        integer :: bit

        call begin_row(table, summary)
        if (summary%records > 0) then
            call table%add(gps_date_text(summary%first_seconds, summary%first_fraction), &
                           gps_date_text(summary%last_seconds, summary%last_fraction))
        else
            call table%add_nothing(2)
        end if
        call table%add(summary%interval, summary%interval > 0)
        call table%add(summary%gaps)
        call table%add(summary%duplicates)
        call table%add(summary%unsorted)
        flags = ''
        do bit = 0, 7       ! which are set in how many records: 2:100 3:100
            call table%add(summary%flags(bit))
            if (summary%flags(bit) > 0) flags = flags//' '//integer_text(bit)//':'//integer_text(summary%flags(bit))
        end do
        call table%add(adjustl(flags), join(padded(summary%warnings), '; '))
    end subroutine add_row

    !> What a row of a file begins with: file, product, satellite, format, records, first and last time.
    subroutine begin_row(table, summary)
        type(data_table_t), intent(inout) :: table
        type(level1_summary_t), intent(in) :: summary

        call table%add(name_of(summary%path), summary%layout%product, summary%satellite, &
                       merge('binary', 'text  ', summary%header%binary))
        call table%add(summary%records)
        if (summary%records > 0) then
            call table%add(real_text(summary%first_seconds + summary%first_fraction), &
                           real_text(summary%last_seconds + summary%last_fraction))
        else
            call table%add_nothing(2)
        end if
    end subroutine begin_row

    !> Arguments and help of `gracecg level1 dump`.
    subroutine declare_level1_dump(arguments)
        type(arguments_t), intent(inout) :: arguments

        call arguments%describe('level1 dump', 'FILE', 1, 1, &
                                'Shows the values of a Level-1 file: a row for each column with number, first, last, mean, '// &
                                'least and greatest value, or the records themselves. Columns have the names of the '// &
                                'headers (fractions time_frac, satellites id); flags are integers; values that a record has '// &
                                'not are not counted.', &
                                'gracecg level1 dump '//ACC)
        call arguments%add_option('--format', 'FORMAT', 'csv: statistics; records: the values', choices=DUMP_FORMATS, &
                                  default='csv')
    end subroutine declare_level1_dump

    !> The work of `gracecg level1 dump`.
    subroutine run_level1_dump(arguments, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: misuse, error

        character(:), allocatable :: format

        call arguments%get('--format', format, misuse)
        if (allocated(misuse)) return
        console%format = 'csv'
        if (format == 'csv') then
            call dump_statistics(arguments%positional(1), console, error)
        else
            call dump_records(arguments%positional(1), console, error)
        end if
    end subroutine run_level1_dump

    !> A row for each field.
    subroutine dump_statistics(path, console, error)
        character(*), intent(in) :: path
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error

        type(level1_summary_t) :: summary
        type(data_table_t) :: table
        type(results_t) :: results
        integer :: i

        call summarise_level1(path, summary, error, with_fields=.true.)
        if (allocated(error)) return
        call table%columns_of('file,product,satellite,format,records,first,last,column,count,first_value,last_value,mean,'// &
                              'min,max')
        do i = 1, size(summary%fields)
            associate (field => summary%layout%fields(i))
                if (field%channel > 0 .and. summary%fields(i)%count == 0) cycle
                call begin_row(table, summary)
                call table%add(trim(field%name))
                call add_statistics(table, summary%fields(i), field%kind)
            end associate
        end do
        call results%publish(table, console, error)
        if (.not. allocated(error)) call tell_warnings(path, summary%warnings, console)
    end subroutine dump_statistics

    !> Count, first and last value, mean, least and greatest; of letters the first two.
    subroutine add_statistics(table, field, kind)
        type(data_table_t), intent(inout) :: table
        type(field_summary_t), intent(in) :: field
        integer, intent(in) :: kind

        integer :: i

        call table%add(field%count)
        associate (values => [field%first, field%last, field%mean(), field%least, field%greatest])
            do i = 1, size(values)
                if (field%count == 0 .or. (kind == KIND_LETTER .and. i > 2)) then
                    call table%add_nothing()
                else if (i == 3) then
                    call table%add(values(i))
                else
                    call table%add(value_text(values(i), kind))
                end if
            end do
        end associate
    end subroutine add_statistics

    !> A value: integers and flags as integers, letters as letters, reals so that they read back exactly.
    pure function value_text(value, kind) result(text)
        real(dp), intent(in) :: value
        integer, intent(in) :: kind
        character(:), allocatable :: text

        if (kind == KIND_LETTER) then
            text = achar(nint(value))
        else if (kind == KIND_F8 .or. kind == KIND_F4) then
            text = real_text(value)
        else
            text = integer_text(nint(value, i8))
        end if
    end function value_text

    !> The records: a column for each field that the table of products has.
    subroutine dump_records(path, console, error)
        character(*), intent(in) :: path
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error

        type(level1_reader_t) :: reader
        type(level1_block_t) :: block
        character(:), allocatable :: line
        integer :: i, k

        call reader%open(path, error)
        if (allocated(error)) return
        call console%data(join(reader%layout%fields%name, ','))
        do
            call reader%next(block, error)
            if (allocated(error)) return
            if (block%count == 0) exit
            do i = 1, block%count
                line = ''
                do k = 1, size(reader%layout%fields)
                    if (k > 1) line = line//','
                    if (.not. ieee_is_nan(block%values(i, k))) &
                        line = line//value_text(block%values(i, k), reader%layout%fields(k)%kind)
                end do
                call console%data(line)
            end do
        end do
        call tell_warnings(path, reader%warnings, console)
    end subroutine dump_records

    subroutine tell_warnings(path, warnings, console)
        character(*), intent(in) :: path
        type(string_t), intent(in) :: warnings(:)
        type(console_t), intent(inout) :: console

        integer :: i

        do i = 1, size(warnings)
            call console%warn(name_of(path)//': '//warnings(i)%text)
        end do
    end subroutine tell_warnings

    !> Arguments and help of `gracecg level1 convert`.
    subroutine declare_level1_convert(arguments)
        type(arguments_t), intent(inout) :: arguments

        call arguments%describe('level1 convert', 'FILE', 1, 1, &
                                'Writes a text file as binary (GRACE''s, for products that have it), or a binary file as '// &
                                'text. Numbers stay what they are, but where binary has single precision. GNI1B, GNV1B, SCA1B, '// &
                                'ACT1B, ACC1B, MAG1B, MAS1B and THR1B also go to files of others and back: instrument files of '// &
                                'GROOPS, and CCSDS messages (OEM of orbits, AEM of attitudes); such a FILE becomes the '// &
                                'Level-1 file that the name of --out says.', &
                                'gracecg level1 convert '//ACC//' --out ACC1A_2023-06-01_C_04.dat')
        call arguments%add_option('--as', 'FORM', 'of the file to write: level1, groops or ccsds', choices=FORMS, default='level1')
        call arguments%add_option('--out', 'FILE', 'file to write', required=.true.)
    end subroutine declare_level1_convert

    !> The work of `gracecg level1 convert`.
    subroutine run_level1_convert(arguments, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: misuse, error

        type(string_t), allocatable :: warnings(:)
        character(:), allocatable :: out, form

        call arguments%get('--out', out, misuse)
        call arguments%get('--as', form, misuse)
        if (.not. allocated(misuse)) &
            call refuse_if(out == arguments%positional(1), 'option --out: the same file as the input', misuse)
        if (allocated(misuse)) return
        call exchange_level1(arguments%positional(1), out, form, warnings, error)
        if (allocated(error)) return
        call console%warn_all(warnings)
        call console%line('wrote '//out)
    end subroutine run_level1_convert

    !> Arguments and help of `gracecg level1 check`.
    subroutine declare_level1_check(arguments)
        type(arguments_t), intent(inout) :: arguments

        call arguments%describe('level1 check', 'PLACE ...', 1, MOST_PLACES, &
                                'Numbers of a day of Level-1 data that tell whether files, time and frames were understood: '// &
                                'sampling, means and noise of the accelerometer, tags of 1A against 1B, rates and noise of '// &
                                'the attitude, orbit in body axes, magnetometer against the IGRF, rod currents and their '// &
                                'gain, gyros, thrusters, gas. Each has a verdict: ok, or unusual for such data. '//PLACES_ARE, &
                                'gracecg level1 check day')
        call add_day_options(arguments)
        call add_format_option(arguments)
    end subroutine declare_level1_check

    !> The work of `gracecg level1 check`.
    subroutine run_level1_check(arguments, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: misuse, error

        type(level1_folder_t) :: files
        type(level1_check_t) :: check
        type(data_table_t) :: table
        type(results_t) :: results
        character(:), allocatable :: satellite, day
        integer :: i

        call arguments%get('--satellite', satellite, misuse)
        call arguments%get('--day', day, misuse)
        call take_format(arguments, console, misuse)
        if (allocated(misuse)) return
        call open_level1_folder(padded(arguments%words), satellite, files, error, day)
        if (.not. allocated(error)) call check_level1(files, check, error)
        if (allocated(error)) return
        call table%column('quantity', 'a', 'quantity')
        call table%column('value', 'es16.8', 'value')
        call table%column('unit', 'a', 'unit')
        call table%column('verdict', 'a', 'verdict')
        do i = 1, size(check%rows)
            call table%add(check%rows(i)%quantity, [check%rows(i)%value])
            call table%add(check%rows(i)%unit, merge('ok     ', 'unusual', check%rows(i)%is_usual()))
        end do
        call console%warn_all(check%warnings)
        call console%line('satellite '//files%satellite//', '//files%date)
        call console%table(table)
        call console%line(integer_text(count(.not. check%rows%is_usual()))//' of '// &
                          integer_text(size(check%rows))//' numbers are unusual')
        call results%open('level1 check')
        call results%member('satellite', files%satellite)
        call results%member('date', files%date)
        call results%publish(table, console, error)
    end subroutine run_level1_check
end module gracecg_level1_command_files
