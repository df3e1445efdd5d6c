!> What is filed of an estimate from Level-1 data: the VCM1B record, the line of the SOE file, the trim commands.
module gracecg_level1_results
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_constants, only: AXES, MILLIMETRE
    use gracecg_base_error, only: error_t
    use gracecg_base_text, only: integer_text, real_text
    use gracecg_files_file, only: output_file_t, appended_file_t, check_writable
    use gracecg_level1_header, only: level1_header_t
    use gracecg_level1_products, only: level1_layout_t, level1_layout, satellite_of_grace_fo
    use gracecg_level1_setup, only: level1_setup_t
    use gracecg_level1_writer, only: level1_writer_t
    use gracecg_environment_time, only: utc_text
    use gracecg_level1_calibration, only: level1_calibration_t, middle_of, middle_of_span
    use gracecg_level1_outcome, only: level1_estimate_t
    use gracecg_level1_solution, only: level1_solution_t, sigma_of
    implicit none
    private
    public :: trim_command_t, trim_commands, write_vcm, write_event, write_offsets

    type :: trim_command_t
        !! One command to a trim mass
        integer :: axis = 0    !! 1, 2, 3: x, y, z of SRF
        integer :: steps = 0                    !! With its sign
        character(80) :: text = ''    !! The command in words
    end type trim_command_t

    real(dp), parameter :: STEPS_A_SECOND = 50  !! Of a trim mass: 0.125 mm/s in steps of 2.5 um

contains

    !> The commands that move the CG by +d: steps = nint(change/step M/trim mass) on each axis, in commands of at most
    !> so many steps.
    subroutine trim_commands(setup, offset, commands)
        type(level1_setup_t), intent(in) :: setup
        real(dp), intent(in) :: offset(3)           !! d, m
        type(trim_command_t), allocatable, intent(out) :: commands(:)

        type(trim_command_t) :: command
        integer :: axis, left, now

        allocate (commands(0))
        do axis = 1, 3
            left = nint(offset(axis)/setup%trim_step*setup%mass/setup%trim_mass)
            do while (left /= 0)
                now = sign(min(abs(left), setup%trim_most), left)
                command%axis = axis
                command%steps = now
                command%text = 'axis '//AXES(axis)//', '//integer_text(abs(now))//' steps '// &
                    merge('POS', 'NEG', now > 0)//' ('//integer_text(nint(abs(now)/STEPS_A_SECOND))//' s)'
                commands = [commands, command]
                left = left - now
            end do
        end do
    end subroutine trim_commands

    !> Writes the CoM in SRF, -d, as a VCM1B file with one record.
    subroutine write_vcm(path, calibration, estimate, error)
        character(*), intent(in) :: path    !! Of the file
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_estimate_t), intent(in) :: estimate
        type(error_t), allocatable, intent(out) :: error

        type(level1_writer_t) :: writer
        type(level1_layout_t) :: layout
        type(level1_header_t) :: header
        real(dp) :: vector(3), values(7)

        call level1_layout('VCM1B', satellite_of_grace_fo(calibration%satellite), layout, error)
        if (allocated(error)) return
        vector = -estimate%solutions(1)%offset
        values(1) = anint(middle_of(calibration))
        values(2) = iachar(calibration%satellite)
        values(3) = norm2(vector)
        values(4:6) = vector/max(norm2(vector), tiny(1.0_dp))
        values(7) = 0
        header%satellite = calibration%satellite
        header%records = 1
        header%first_time = values(1)
        header%last_time = values(1)
        call writer%open(path, layout, .false., header, error)
        if (allocated(error)) return
        call writer%record(values)
        call writer%commit(error)
    end subroutine write_vcm

    !> Adds the CoM as a VCM event to a file of events, which is made where there is none. Fails when it is an input.
    subroutine write_event(path, calibration, estimate, error)
        character(*), intent(in) :: path    !! Of the file
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_estimate_t), intent(in) :: estimate
        type(error_t), allocatable, intent(out) :: error

        type(appended_file_t) :: file

        call check_writable(path, error)
        if (.not. allocated(error)) call file%open(path, error)
        if (allocated(error)) return
        associate (d => estimate%solutions(1)%offset)
            call file%line(integer_text(nint(middle_of(calibration), i8))//' GRACE'//calibration%satellite//' VCM 3 '// &
                           real_text(-d(1))//' '//real_text(-d(2))//' '//real_text(-d(3))//' by gracecg, source '// &
                           trim(estimate%solutions(1)%source)//', flag '//integer_text(estimate%flag), error)
        end associate
    end subroutine write_event

    !> Writes the offset by each span that determines it, as CSV: the middle of the span, d and its standard deviations.
    subroutine write_offsets(path, calibration, solution, error)
        character(*), intent(in) :: path    !! Of the file
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_solution_t), intent(in) :: solution
        type(error_t), allocatable, intent(out) :: error

        type(output_file_t) :: file
        character(:), allocatable :: line
        real(dp) :: values(6)
        integer :: i, k

        call file%open(path, error)
        if (allocated(error)) return
        call file%line('time_utc,dx_mm,dy_mm,dz_mm,sigma_x_mm,sigma_y_mm,sigma_z_mm')
        do i = 1, size(calibration%spans)
            if (.not. solution%span_covariance(1, 1, i) > 0) cycle
            line = trim(utc_text(middle_of_span(calibration, i)))
            values = [solution%span_offset(:, i), sigma_of(solution, i)]/MILLIMETRE
            do k = 1, size(values)
                line = line//','//real_text(values(k))
            end do
            call file%line(line)
        end do
        call file%commit(error)
    end subroutine write_offsets
end module gracecg_level1_results
