!> gracecg verify: the verification of CSR-TM-00-01 section 5.3.
module gracecg_cli_verify
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: AXES
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_text, only: string_t, append
    use gracecg_files_file, only: make_directory
    use gracecg_simulation_case, only: case_t
    use gracecg_simulation_case_library, only: find_case
    use gracecg_studies_curves, only: verification_t, verify_case, window_check_t, &
        check_windows, window_counts_t, count_windows, write_curves, curves_file_name, CURVE_NAMES
    use gracecg_cli_arguments, only: arguments_t
    use gracecg_cli_console, only: console_t
    use gracecg_cli_number_text, only: percent_text, share_text
    implicit none
    private
    public :: declare_verify, run_verify, window_verdict

    character(*), parameter :: DEFAULT_CASES(2) = [character(7) :: 'front-1', 'back-1']
    integer, parameter :: MOST_CASES = 100
    integer, parameter :: CASE_WITH_WINDOWS = 1     !! Figures 5.2-5.8 show case 1 of each satellite

contains

    !> Arguments and help of `gracecg verify`.
    subroutine declare_verify(arguments)
        type(arguments_t), intent(inout) :: arguments

        call arguments%describe('verify', '[CASE ...]', 0, MOST_CASES, &
                                'Computes the curves of Figures 5.2-5.8 of CSR-TM-00-01 along '// &
                                'the arcs of the cases (front-1 and back-1 when none is '// &
                                'named). Case 1 of a satellite is compared with the axis '// &
                                'windows that the report prints: a curve is inside when it '// &
                                'leaves its window by at most 5 % of its width.', &
                                'gracecg verify front-1 back-1 --out curves')
        call arguments%add_option('--out', 'DIR', &
                                  'folder for the curves, verify_CASE.csv; made if it is not there')
    end subroutine declare_verify

    !> The work of `gracecg verify`.
    subroutine run_verify(arguments, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: misuse, error

        type(case_t), allocatable :: cases(:)
        type(verification_t) :: verification
        character(:), allocatable :: folder, path
        integer :: i

        call arguments%get('--out', folder, misuse, default='')
        if (allocated(misuse)) return
        call find_cases(arguments, cases, error)
        if (.not. allocated(error) .and. folder /= '') call make_directory(folder, error)
        if (allocated(error)) return
        do i = 1, size(cases)
            call console%progress('verify: '//trim(cases(i)%name))
            call verify_case(cases(i), verification, error)
            if (allocated(error)) return
            if (i > 1) call console%line('')
            call show(cases(i), verification, console)
            if (folder == '') cycle
            path = folder//'/'//curves_file_name(cases(i)%name)
            call write_curves(path, 'verify', cases(i)%name, verification, error)
            if (allocated(error)) return
            call console%line('written: '//path)
        end do
    end subroutine run_verify

    !> The cases named, each once.
    subroutine find_cases(arguments, cases, error)
        type(arguments_t), intent(in) :: arguments
        type(case_t), allocatable, intent(out) :: cases(:)
        type(error_t), allocatable, intent(out) :: error

        type(string_t), allocatable :: names(:)
        integer :: i, k

        allocate (names(0))
        do i = 1, arguments%positional_count()
            call append(names, arguments%positional(i))
        end do
        if (size(names) == 0) then
            do i = 1, size(DEFAULT_CASES)
                call append(names, trim(DEFAULT_CASES(i)))
            end do
        end if
        allocate (cases(size(names)))
        do i = 1, size(names)
            call find_case(names(i)%text, cases(i), error)
            if (allocated(error)) return
            do k = 1, i - 1
                if (cases(k)%name /= cases(i)%name) cycle
                call fail(error, 'two of the cases have the name "'//trim(cases(i)%name)//'"')
                return
            end do
        end do
    end subroutine find_cases

    subroutine show(case, verification, console)
        type(case_t), intent(in) :: case
        type(verification_t), intent(in) :: verification
        type(console_t), intent(inout) :: console

        if (case%number == CASE_WITH_WINDOWS) then
            call show_windows(trim(case%name), &
                              check_windows(trim(case%satellite%name), verification), console)
        else
            call show_ranges(trim(case%name), verification, console)
        end if
    end subroutine show

    !> A line for each curve that has a printed window, and the counts.
    subroutine show_windows(name, checks, console)
        character(*), intent(in) :: name
        type(window_check_t), intent(in) :: checks(:)
        type(console_t), intent(inout) :: console

        type(window_counts_t) :: counts
        character(130) :: line
        integer :: i

        call console%line(name//': curves and the printed axis windows, SI units, body axes')
        call console%line('fig  quantity           axis  window low  window high  least        '// &
                          'greatest     mean         verdict')
        do i = 1, size(checks)
            associate (c => checks(i))
                write (line, '(a5, a19, a4, 5(es12.4, 1x))') c%figure, c%quantity, c%axis, &
                    c%low, c%high, c%least, c%greatest, c%mean
                call console%line(line(:94)//window_verdict(c))
            end associate
        end do
        counts = count_windows(checks)
        call console%line('inside, attitude dynamics only: '//share_text(counts%attitude_inside, counts%attitude))
        call console%line('inside, surface forces and torques: '//share_text(counts%surface_inside, counts%surface))
        call console%line('mean within 15 % of the window''s centre, surface forces and torques: '// &
                          share_text(counts%surface_near, counts%surface))
    end subroutine show_windows

    !> A check in words.
    function window_verdict(check) result(text)
        type(window_check_t), intent(in) :: check
        character(:), allocatable :: text

        if (check%excess <= 0) then
            text = 'inside'
        else if (check%inside) then
            text = 'inside, leaves by '//percent_text(check%excess)
        else
            text = 'outside, leaves by '//percent_text(check%excess)
        end if
        if (check%attitude_only) return
        if (check%near_centre) then
            text = text//'; mean within 15 %'
        else
            text = text//'; mean off by '//percent_text(check%centre_difference)
        end if
    end function window_verdict

    !> A line for each curve: its range and mean.
    subroutine show_ranges(name, verification, console)
        character(*), intent(in) :: name
        type(verification_t), intent(in) :: verification
        type(console_t), intent(inout) :: console

        character(80) :: line
        integer :: curve, axis

        call console%line(name//': curves, SI units, body axes')
        call console%line('quantity           axis  least        greatest     mean')
        do curve = 1, size(CURVE_NAMES)
            do axis = 1, size(AXES)
                associate (values => verification%curve(axis, curve, :))
                    write (line, '(a19, a4, 3(es12.4, 1x))') CURVE_NAMES(curve), AXES(axis), &
                        minval(values), maxval(values), sum(values)/size(values)
                end associate
                call console%line(trim(line))
            end do
        end do
    end subroutine show_ranges
end module gracecg_cli_verify
