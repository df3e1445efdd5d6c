!> Writing Level-1 files: text as of GRACE-FO or GRACE, and binary as of GRACE.
!>
!>     call level1_layout('MAG1A', .true., layout, error)
!>     call writer%open('MAG1A_2020-02-01_C_04.txt', layout, .false., header, error)   ! header: level1_header_t
!>     call writer%record(values)                          ! by field of the layout; NaN: not in this record
!>     call writer%commit(error)
!>
!> Reals of text have the fewest of 15 to 17 digits that give the same number back: those of official files.
module gracecg_level1_writer
    use, intrinsic :: iso_fortran_env, only: real32
    use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
    use gracecg_base_kinds, only: dp, i4, i8
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_decimal, only: scan_real
    use gracecg_base_text, only: integer_text, real_text, string_t, append
    use gracecg_base_version, only: VERSION
    use gracecg_files_file, only: output_file_t
    use gracecg_level1_products, only: level1_layout_t, KIND_I1, KIND_I2, KIND_I4, KIND_U1, KIND_U2, &
        KIND_U4, KIND_F4, KIND_F8, KIND_LETTER, KIND_NUMERAL, KIND_FLAG8, KIND_FLAG32
    use gracecg_level1_header, only: level1_header_t, YAML_FIRST, YAML_LAST, CARDS_LAST, CARD_LENGTH, &
        LABEL_LENGTH
    use gracecg_level1_time, only: gps_date_text
    implicit none
    private
    public :: level1_writer_t, general_text

    character(1), parameter :: LF = achar(10)
    integer, parameter :: LONGEST_RECORD = 8192     !! Characters or bytes; the longest is that of GNV1A
    !> Text has at least 10 digits of a number of single precision (16, housekeeping 10): more than that is a loss
    real(dp), parameter :: TEXT_DIGITS = 5e-10_dp
    !> A block number of GRACE-FO text counts on where that of binary begins anew
    integer, parameter :: BLOCK_NUMBERS = 65536

    type :: level1_writer_t
        !! A Level-1 file being written; it appears under its name at `commit`
        private
        type(output_file_t) :: file
        character(:), allocatable :: path
        type(level1_layout_t) :: layout
        logical :: binary = .false.
        integer(i8) :: records = 0
        integer(i8), allocatable :: rounded(:)      !! Values that lost digits in single precision, by field
        integer(i8) :: wrapped = 0                  !! Block numbers beyond the 16 bits of binary
        type(error_t), allocatable :: failure       !! The first one
    contains
        procedure :: open => open_writer        !! Begins a file with its header
        procedure :: record => write_record     !! Writes a record
        procedure :: commit => commit_writer    !! Ends the file and gives it its name
        procedure :: discard => discard_writer  !! Leaves nothing behind
        procedure :: losses                     !! What could not be kept
    end type level1_writer_t

contains

    !> Begins a file. Fails when it cannot be written, or binary is wanted of what has no binary form.
    subroutine open_writer(self, path, layout, binary, header, error)
        class(level1_writer_t), intent(inout) :: self
        character(*), intent(in) :: path                !! Of the file to write; an existing one is replaced
        type(level1_layout_t), intent(in) :: layout     !! Of the product
        logical, intent(in) :: binary                   !! Binary, not text
        type(level1_header_t), intent(in) :: header     !! Satellite, number of records, first and last time, version
        type(error_t), allocatable, intent(out) :: error

        if (allocated(self%failure)) deallocate (self%failure)
        self%path = trim(path)
        self%layout = layout
        self%binary = binary
        self%records = 0
        self%wrapped = 0
        self%rounded = int(0*layout%fields%kind, i8)
        if (binary .and. .not. layout%has_binary) then
            call fail(error, self%path//': '//layout%product//' of '//trim(merge('GRACE-FO', 'GRACE   ', layout%grace_fo))// &
                      ' has no binary form; it can be written as text only')
            return
        end if
        call self%file%open(path, error)
        if (allocated(error)) return
        if (binary .or. .not. layout%grace_fo .or. (layout%is_event .and. layout%keeps_last)) then
            call write_cards(self, header)
        else
            call write_yaml(self, header)
        end if
    end subroutine open_writer

    !> Lines of 80 characters: label and value.
    subroutine write_cards(self, header)
        class(level1_writer_t), intent(inout) :: self
        type(level1_header_t), intent(in) :: header

        integer, parameter :: CARDS = 11

        call card('PRODUCER AGENCY', 'GRACECG '//VERSION)
        call card('FILENAME', standard_name(self, header))
        call card('PROCESS LEVEL (1A OR 1B)', self%layout%product(4:5))
        call card('FILE FORMAT 0=BINARY 1=ASCII', merge('0', '1', self%binary))
        call card('NUMBER OF HEADER RECORDS', integer_text(CARDS))
        call card('SATELLITE NAME', 'GRACE '//header%satellite)
        call card('TIME EPOCH (GPS TIME)', '2000-01-01 12:00:00')
        call card('TIME FIRST OBS(SEC PAST EPOCH)', time_text(header%first_time, ' '))
        call card('TIME LAST OBS(SEC PAST EPOCH)', time_text(header%last_time, ' '))
        call card('NUMBER OF DATA RECORDS', integer_text(max(0, header%records)))
        call card('SOFTWARE VERSION', 'gracecg '//VERSION)
        call self%file%bytes(CARDS_LAST//repeat(' ', CARD_LENGTH - len(CARDS_LAST))//LF)

    contains

        subroutine card(label, value)
            character(*), intent(in) :: label, value

            character(CARD_LENGTH) :: line

            line = label
            line(LABEL_LENGTH + 1:) = ': '//value
            call self%file%bytes(line//LF)
        end subroutine card
    end subroutine write_cards

    !> 738849600.007739 (2023-06-01 00:00:00.007739)
    function time_text(time, between) result(text)
        real(dp), intent(in) :: time            !! s past 2000-01-01 12:00 GPS
        character(1), intent(in) :: between     !! Date and time of day
        character(54) :: text

        character(24) :: number
        character(26) :: date

        write (number, '(f0.6)') time
        if (number(1:1) == '.') number = '0'//trim(number)
        date = gps_date_text(floor(time, i8), time - floor(time, i8))
        date(11:11) = between
        text = trim(number)//' ('//date//')'
    end function time_text

    !> The header of GRACE-FO text.
    subroutine write_yaml(self, header)
        class(level1_writer_t), intent(inout) :: self
        type(level1_header_t), intent(in) :: header

        character(26) :: first, last
        character(24) :: number
        integer :: i

        first = gps_date_text(floor(header%first_time, i8), header%first_time - floor(header%first_time, i8))
        last = gps_date_text(floor(header%last_time, i8), header%last_time - floor(header%last_time, i8))
        call self%file%line(YAML_FIRST)
        call self%file%line('  dimensions:')
        call self%file%line('    num_records: '//integer_text(max(0, header%records)))
        call self%file%line('  global_attributes:')
        call self%file%line('    creator_name: gracecg '//VERSION)
        call self%file%line('    platform: GRACE '//header%satellite)
        call self%file%line('    processing_level: '//self%layout%product(4:5))
        call self%file%line('    product_version: 04')
        call self%file%line('    time_coverage_start: '//first(:22))
        call self%file%line('    time_coverage_stop: '//last(:22))
        call self%file%line('    title: GRACE-FO Level-'//self%layout%product(4:5)//' '// &
                            trim(title_of(self%layout%product(:3)))//' Data')
        call self%file%line('  non-standard_attributes:')
        call self%file%line('    epoch_time: 2000-01-01T12:00:00.00')
        call self%file%line('    software_version: '//VERSION)
        write (number, '(f0.6)') header%first_time
        call self%file%line('    start_time_epoch_secs: '//trim(number))
        write (number, '(f0.6)') header%last_time
        call self%file%line('    stop_time_epoch_secs: '//trim(number))
        call self%file%line('  variables:')
        do i = 1, size(self%layout%fields)
            associate (field => self%layout%fields(i))
                if (field%channel > 1) cycle
                call self%file%line('    - '//trim(field%name)//':')
                if (field%bit >= 0) then
                    call self%file%line('        comment: next column, if prod_flag bit set')
                else
                    call self%file%line('        comment: column '//integer_text(i))
                end if
            end associate
        end do
        call self%file%line(YAML_LAST)
    end subroutine write_yaml

    pure function title_of(product) result(title)
        character(3), intent(in) :: product
        character(32) :: title

        select case (product)
        case ('ACC')
            title = 'Accelerometer'
        case ('ACT')
            title = 'Transformed Accelerometer'
        case ('AHK')
            title = 'Accelerometer Housekeeping'
        case ('SCA')
            title = 'Star Camera'
        case ('MAG')
            title = 'Magnetometer and Torque Rod'
        case ('THR')
            title = 'Thruster'
        case ('TNK')
            title = 'Tank Temperature and Pressure'
        case ('MAS')
            title = 'Mass'
        case ('TIM')
            title = 'Clock'
        case ('CLK')
            title = 'Clock Offset'
        case ('GNV')
            title = 'GPS Navigation'
        case ('GNI')
            title = 'Intermediate GPS Navigation'
        case default
            title = product
        end select
    end function title_of

    !> ACC1B_2003-09-14_A_02.dat
    function standard_name(self, header) result(name)
        class(level1_writer_t), intent(in) :: self
        type(level1_header_t), intent(in) :: header
        character(25) :: name

        character(26) :: date

        date = gps_date_text(floor(header%first_time, i8), 0.0_dp)
        name = self%layout%product//'_'//date(:10)//'_'//header%satellite//'_'// &
            merge('04', '02', self%layout%grace_fo)//merge('.dat', '.txt', self%binary)
    end function standard_name

    !> Writes a record. What is wrong with it is remembered and told by `commit`.
    subroutine write_record(self, values)
        class(level1_writer_t), intent(inout) :: self
        real(dp), intent(in) :: values(:)   !! By field; letters as their codes; NaN: not in this record

        character(LONGEST_RECORD) :: text
        integer :: length, i, field, order(size(self%layout%fields))
        integer(i8) :: flag

        if (allocated(self%failure)) return
        self%records = self%records + 1
        order = [(i, i=1, size(order))]
        if (self%layout%id_first .and. .not. self%binary) then
            order(self%layout%time_ref) = self%layout%id
            order(self%layout%id) = self%layout%time_ref
        end if
        length = 0
        flag = 0
        do i = 1, size(order)
            field = order(i)
            associate (f => self%layout%fields(field))
                if (f%bit >= 0) then
                    if (.not. btest(flag, f%bit)) cycle
                else if (f%channel > flag) then
                    cycle
                end if
                if (ieee_is_nan(values(field)) .and. f%kind /= KIND_F4 .and. f%kind /= KIND_F8) then
                    call fail(self%failure, self%path//': record '//integer_text(self%records)//' has no '//trim(f%name))
                    return
                end if
                if (field == self%layout%prod_flag .or. field == self%layout%channels) flag = nint(values(field), i8)
                if (self%binary) then
                    call append_binary(self, values(field), field, text, length)
                else
                    call append_text(values(field), f%kind, text, length)
                end if
            end associate
            if (allocated(self%failure)) return
        end do
        if (self%binary) then
            call self%file%bytes(text(:length))
        else
            text(length:length) = LF
            call self%file%bytes(text(:length))
        end if
    end subroutine write_record

    !> Writes a value and a blank.
    subroutine append_text(value, kind, text, length)
        real(dp), intent(in) :: value
        integer, intent(in) :: kind
        character(*), intent(inout) :: text
        integer, intent(inout) :: length

        character(32) :: word
        integer :: i

        select case (kind)
        case (KIND_F8, KIND_F4)
            word = general_text(value, kind == KIND_F4)
        case (KIND_LETTER)
            word = achar(nint(value))
        case (KIND_FLAG8)
            write (word, '(8i1)') [(merge(1, 0, btest(nint(value, i8), i)), i=7, 0, -1)]
        case (KIND_FLAG32)
            write (word, '(32i1)') [(merge(1, 0, btest(nint(value, i8), i)), i=31, 0, -1)]
        case default
            word = integer_text(nint(value, i8))
        end select
        text(length + 1:) = trim(word)//' '
        length = length + len_trim(word) + 1
    end subroutine append_text

    !> A number in the form that official files have: -1.25e-05, 65000, 1e+33. The fewest of 15 to 17 digits that
    !> give the number back, without needless zeros; 16 always do for a number of single precision.
    function general_text(value, single) result(text)
        real(dp), intent(in) :: value       !! NaN is 'nan'
        logical, intent(in) :: single       !! It is one of single precision
        character(32) :: text

        character(11), parameter :: FORMATS(15:17) = ['(es32.14e3)', '(es32.15e3)', '(es32.16e3)']
        character(32) :: buffer, digits
        real(dp) :: again
        integer :: places, exponent, last, at, status
        logical :: ok

        text = 'nan'
        if (.not. abs(value) <= huge(value)) return
        text = '0'
        if (abs(value) <= 0) return
        do places = 15, merge(16, 17, single)
            write (buffer, FORMATS(places)) abs(value)
            buffer = adjustl(buffer)
            at = 1
            call scan_real(buffer, at, again, ok)
            if (abs(again - abs(value)) <= 0) exit
        end do
        at = index(buffer, 'E')
        read (buffer(at + 1:), *, iostat=status) exponent
        digits = buffer(1:1)//buffer(3:at - 1)
        last = max(1, verify(trim(digits), '0', back=.true.))
        if (exponent < -4 .or. exponent >= 16) then
            text = digits(1:1)
            if (last > 1) text = digits(1:1)//'.'//digits(2:last)
            write (buffer, '(i3.2)') abs(exponent)
            text = trim(text)//'e'//merge('-', '+', exponent < 0)//adjustl(buffer)
        else if (exponent < 0) then
            text = '0.'//repeat('0', -exponent - 1)//digits(:last)
        else if (last <= exponent + 1) then
            text = digits(:last)//repeat('0', exponent + 1 - last)
        else
            text = digits(:exponent + 1)//'.'//digits(exponent + 2:last)
        end if
        if (value < 0) text = '-'//trim(text)
    end function general_text

    !> Appends the bytes of a value, most significant first.
    subroutine append_binary(self, value, field, text, length)
        class(level1_writer_t), intent(inout) :: self
        real(dp), intent(in) :: value
        integer, intent(in) :: field
        character(*), intent(inout) :: text
        integer, intent(inout) :: length

        integer(i8) :: word
        real(real32) :: single
        integer :: i, bytes

        bytes = self%layout%fields(field)%bytes
        select case (self%layout%fields(field)%kind)
        case (KIND_F8)
            word = transfer(value, word)
        case (KIND_F4)
            if (abs(value) > huge(single)) then
                call fail(self%failure, self%path//': record '//integer_text(self%records)//', '// &
                          trim(self%layout%fields(field)%name)//': '//real_text(value)// &
                          ' is too large for single precision, which binary has')
                return
            end if
            single = real(value, real32)
            if (abs(real(single, dp) - value) > TEXT_DIGITS*abs(value)) self%rounded(field) = self%rounded(field) + 1
            word = transfer(single, 0_i4)
        case (KIND_U2)
            word = nint(value, i8)
            if (word >= BLOCK_NUMBERS) self%wrapped = self%wrapped + 1
        case (KIND_NUMERAL)
            word = nint(value, i8) + iachar('0')
        case default
            word = nint(value, i8)
        end select
        do i = bytes - 1, 0, -1
            length = length + 1
            text(length:length) = achar(int(ibits(word, 8*i, 8)))
        end do
    end subroutine append_binary

    !> Ends the file and gives it its name. After a failure there is no file, or still an older one.
    subroutine commit_writer(self, error)
        class(level1_writer_t), intent(inout) :: self
        type(error_t), allocatable, intent(out) :: error

        if (allocated(self%failure)) then
            call move_alloc(self%failure, error)
            call self%file%discard()
        else
            call self%file%commit(error)
        end if
    end subroutine commit_writer

    !> Gives the file up: nothing of it is left.
    subroutine discard_writer(self)
        class(level1_writer_t), intent(inout) :: self

        call self%file%discard()
    end subroutine discard_writer

    !> What of the records the form of the file could not keep: a sentence each; none: all was kept.
    subroutine losses(self, texts)
        class(level1_writer_t), intent(in) :: self
        type(string_t), allocatable, intent(out) :: texts(:)

        integer :: i

        allocate (texts(0))
        do i = 1, size(self%rounded)
            if (self%rounded(i) > 0) &
                call append(texts, integer_text(self%rounded(i))//' values of '//trim(self%layout%fields(i)%name)// &
                            ' were rounded to the single precision that binary has')
        end do
        if (self%wrapped > 0) &
            call append(texts, integer_text(self%wrapped)//' block numbers are beyond the 16 bits of binary: they begin '// &
                        'anew at '//integer_text(BLOCK_NUMBERS))
    end subroutine losses
end module gracecg_level1_writer
