!> gracecg design --whisper: weak tones of the rods all the time, in place of a manoeuvre.
module gracecg_cli_design_whisper
    use gracecg_base_constants, only: MICROMETRE
    use gracecg_files_file, only: output_file_t
    use gracecg_spacecraft_rod_leakage, only: USUAL_ROD_GAIN
    use gracecg_planning_whisper, only: whisper_limits_t, whisper_plan_t, plan_whisper, TIMES
    use gracecg_cli_console, only: quoted_word
    use gracecg_cli_work
    implicit none
    private
    public :: declare_whisper, run_whisper

    real(dp), parameter :: NANOMETRE = 1e-9_dp
    character(13), parameter :: OF_A_MANOEUVRE(12) = [character(13) :: '--manoeuvre', '--at', '--anywhere', '--everywhere', &
        '--duration', '--rods', '--waveforms', '--taper', '--rise-time', '--rate-limit', '--revolutions', '--map']

contains

    !> Options of the tones alone.
    subroutine declare_whisper(arguments)
        type(arguments_t), intent(inout) :: arguments

        type(whisper_limits_t) :: usual

        call arguments%add_option('--whisper', '', 'no manoeuvre, but weak tones on all rods all the time, within --amplitude '// &
                                  '(default '//real_text(usual%moment)//' A m^2), --frequencies (default '// &
                                  real_text(usual%band(1))//' '//real_text(usual%band(2))//' Hz), --pointing-limit and '// &
                                  '--range-limit: sigma after a revolution, a day, a week; --out: how to simulate it')
        call arguments%add_option('--range-limit', 'NM', 'of --whisper: largest error of the range by the turns, through '// &
                                  real_text(usual%tilt_coupling/MICROMETRE)//' um/rad', &
                                  default=real_text(usual%range/NANOMETRE))
    end subroutine declare_whisper

    !> Finds the tones and says what they reach.
    subroutine run_whisper(arguments, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(inout) :: misuse
        type(error_t), allocatable, intent(out) :: error

        type(study_t) :: study
        type(whisper_limits_t) :: limits
        type(whisper_plan_t) :: plan
        type(results_t) :: results
        type(data_table_t) :: reached
        character(:), allocatable :: name
        integer :: i

        do i = 1, size(OF_A_MANOEUVRE)
            call refuse_if(arguments%has(trim(OF_A_MANOEUVRE(i))), 'option '//trim(OF_A_MANOEUVRE(i))//' is of a manoeuvre, '// &
                           'and --whisper has none', misuse)
        end do
        if (arguments%has('--amplitude')) call arguments%get('--amplitude', limits%moment, misuse, low=1e-6_dp, high=1e4_dp, &
                                                             unit='A m^2')
        if (arguments%has('--frequencies')) call arguments%get('--frequencies', limits%band, misuse, low=1e-6_dp, &
                                                               high=1e3_dp, unit='Hz')
        if (arguments%has('--pointing-limit')) then
            call arguments%get('--pointing-limit', limits%turn, misuse, low=1e-9_dp, high=180.0_dp, unit='deg')
            limits%turn = limits%turn*DEGREE
        end if
        call arguments%get('--range-limit', limits%range, misuse, low=1e-9_dp, high=1e9_dp, unit='nm')
        limits%range = limits%range*NANOMETRE
        call take_study(arguments, 'front-1', console, study, misuse, error, may_rest=.true.)
        if (allocated(misuse) .or. allocated(error)) return
        name = 'front-1'
        if (arguments%positional_count() > 0) name = arguments%positional(1)
        associate (case => study%calibrations(1)%case)
            if (.not. arguments%has('--amplitude')) limits%moment = min(limits%moment, case%satellite%rods%largest_moment)
            call plan_whisper(case, limits, plan, error)
            if (allocated(error)) return
            call results%open('design')
            call results%member('case', trim(case%name))
            call show(plan, limits, console, results, reached)
            call results%publish(reached, console, error)
            if (.not. allocated(error) .and. study%path /= '') call write_settings(study%path, name, plan, console, error)
        end associate
    end subroutine run_whisper

    !> The tones, what they do, and what they reach.
    subroutine show(plan, limits, console, results, reached)
        type(whisper_plan_t), intent(in) :: plan
        type(whisper_limits_t), intent(in) :: limits
        type(console_t), intent(inout) :: console
        type(results_t), intent(inout) :: results
        type(data_table_t), intent(out) :: reached

        type(data_table_t) :: tones
        integer :: k

        call tones%column('rod', 'a', 'rod')
        call tones%column('frequency_hz', 'f8.4', 'frequency, Hz')
        call tones%column('moment_a_m2', 'f8.4', 'moment, A m^2')
        call tones%column('current_ma', 'f8.3', 'current, mA')
        call tones%column('turn_urad', 'f8.3', 'turns up to, urad')
        do k = 1, 3
            call tones%add(AXES(k))
            call tones%add([plan%tones(k)%frequency, plan%tones(k)%moment, plan%tones(k)%moment/USUAL_ROD_GAIN, &
                            maxval(plan%tones(k)%turn)*1e6_dp])
        end do
        call console%table(tones)
        call tones%to_json(results, 'tones', units=.false.)
        call console%line('')
        call reached%column('after', 'a', 'after a')
        call axis_columns(reached, 'sigma_', '_mm', 'f9.5', 'sigma, mm')
        call axis_columns(reached, 'noise_alone_', '_mm', 'f9.5', 'by the noise alone, mm')
        do k = 1, size(TIMES)
            call reached%add(trim(TIMES(k)))
            call reached%add([plan%sigma(:, k), plan%sigma_alone(:, k)]/MILLIMETRE)
        end do
        call console%table(reached)
        call console%line('')
        call console%paragraph('sigma: with leakage of the rods and the push of the air estimated; gains of the rods and '// &
                               'scale of the accelerometer count as known (an error of the scale is the same part of d). '// &
                               'All tones turn the satellite by at most '//trim(rounded_text(plan%turn*1e6_dp, 3))// &
                               ' urad, the range by '//trim(rounded_text(plan%range/NANOMETRE, 3))//' nm (limits '// &
                               trim(rounded_text(limits%turn*1e6_dp, 3))//' urad, '// &
                               trim(rounded_text(limits%range/NANOMETRE, 3))//' nm)')
        call results%member('turn_rad', plan%turn)
        call results%member('range_m', plan%range)
    end subroutine show

    !> A day of these tones as settings of `level1 simulate`.
    subroutine write_settings(path, name, plan, console, error)
        character(*), intent(in) :: path, name      !! Of the file; of the case, or its file
        type(whisper_plan_t), intent(in) :: plan
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error

        type(output_file_t) :: file

        call file%open(path, error)
        if (allocated(error)) return
        call file%line('&level1_simulation   ! by gracecg design '//name//' --whisper')
        call file%line('    spans = 0, duration = 86400, rod_control = .true., control_hz = 8e-4, science_ma = 0,')
        call file%line('    firing_interval = 60, 228')
        call file%line('    whisper_ma = '//list_of(plan%tones%moment/USUAL_ROD_GAIN))
        call file%line('    whisper_hz = '//list_of(plan%tones%frequency))
        call file%line('/')
        call file%commit(error)
        if (allocated(error)) return
        call console%line('')
        call console%line('next: gracecg level1 simulate '//quoted_word(name)//' --level1 '//quoted_word(path)//' --out day; '// &
                          'gracecg level1 estimate day --setup day/setup.nml --every 5640')
    end subroutine write_settings

    !> Three numbers of a namelist.
    function list_of(numbers) result(text)
        real(dp), intent(in) :: numbers(3)
        character(:), allocatable :: text

        text = real_text(numbers(1))//', '//real_text(numbers(2))//', '//real_text(numbers(3))
    end function list_of
end module gracecg_cli_design_whisper
